#include "render/internal/composite_pass.h"

#include <array>

#include <glm/vec4.hpp>

namespace pleinair {
namespace {

// The state of a real pixel. Its log radiance, per channel, is held against two predictions: lit
// (l) and shaded (d). With noise sigma (the albedo of one pixel against that of the survey, in log)
// the log odds of lit over shaded are ((x - d)^2 - (x - l)^2) / (2 sigma^2); the median of three
// channels stands against one that is dead or coloured. What the mesh says adds its own log odds,
// so that a dark brick under a weak sun does not pass for shadow; near an edge of the model the
// mesh may be wrong about the place, and says nothing.
constexpr std::string_view kFragmentShader = R"(
uniform sampler2D u_camera_radiance;
uniform sampler2D u_clipped;
uniform sampler2D u_object_layer;
uniform sampler2D u_shadow_mask;
uniform sampler2D u_lookup;
uniform sampler2D u_albedo;
uniform sampler2D u_normal;
uniform sampler2DArray u_sky_response;
uniform sampler2D u_sun_bounce;
uniform sampler2D u_sun_visibility;
uniform int u_has_lookup;
uniform vec3 u_to_sun;
uniform vec3 u_sun_irradiance;
uniform vec3 u_sky_irradiance[128];
uniform int u_sky_shapes;
uniform float u_gain;
out vec4 o_colour;

const float kInvPi = 0.318309886;
const float kHalfMax = 65504.0;
const float kScaled = 128.0 / 255.0;
// One pixel's albedo against the model's, standard deviation in log: bricks, joints, stains around
// a survey texel's mean; a material's guess is worse.
const float kSigmaMeasured = 0.25;
const float kSigmaGuessed = 0.5;
// The mesh is right about sun or shade in 19 of 20 pixels away from its edges (it lacks trees and
// roof edges), and its edges are good to some pixels.
const float kMeshLogOdds = 2.944;
const float kTrustedEdgeDistancePx = 6.0;

float Median(vec3 v) { return max(min(v.r, v.g), min(max(v.r, v.g), v.b)); }

// Share of the disc that the pixel sees without the virtual objects.
float SunWithout(vec3 observed, bool clipped, vec3 lit, vec3 shaded, float model, float edge_distance,
                 bool measured) {
  vec3 floor_value = max(1e-6 * lit, vec3(1e-30));
  vec3 spread = log(max(lit, floor_value) / max(shaded, floor_value));
  vec3 x = log(max(observed, floor_value) / max(shaded, floor_value));
  // A clipped value is a lower bound: it may be as bright as lit.
  if (clipped) x = max(x, spread);
  float sigma = measured ? kSigmaMeasured : kSigmaGuessed;
  float log_odds = Median(spread * (2.0 * x - spread)) / (2.0 * sigma * sigma);
  float trust = clamp(edge_distance / kTrustedEdgeDistancePx, 0.0, 1.0);
  log_odds += (2.0 * model - 1.0) * kMeshLogOdds * trust;
  if (log_odds <= 0.0) return 0.0;
  return model > 0.0 ? model : 1.0;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 object;
  float in_shadow;
  if (u_has_lookup != 0) {
    vec2 place = texelFetch(u_lookup, pixel, 0).xy / vec2(textureSize(u_object_layer, 0));
    bool inside = all(greaterThan(place, vec2(0.0))) && all(lessThan(place, vec2(1.0)));
    object = inside ? texture(u_object_layer, place) : vec4(0.0);
    in_shadow = inside ? texture(u_shadow_mask, place).r : 0.0;
  } else {
    object = texelFetch(u_object_layer, pixel, 0);
    in_shadow = texelFetch(u_shadow_mask, pixel, 0).r;
  }
  if (!(object.a > 0.0) && !(in_shadow > 0.0)) discard;

  vec3 camera = u_gain * texelFetch(u_camera_radiance, pixel, 0).rgb;
  bool is_known = all(greaterThanEqual(camera, vec3(0.0))) && all(lessThan(camera, vec3(1e37)));
  vec3 real = camera;
  bool is_changed = false;
  if (in_shadow > 0.0) {
    vec3 sky = vec3(0.0);
    for (int k = 0; k < u_sky_shapes; ++k) {
      sky += u_sky_irradiance[k] * texelFetch(u_sky_response, ivec3(pixel, k), 0).rgb;
    }
    vec3 normal = texelFetch(u_normal, pixel, 0).rgb;
    vec2 visibility_edge = texelFetch(u_sun_visibility, pixel, 0).rg;
    vec4 albedo = texelFetch(u_albedo, pixel, 0);
    vec3 direct = u_sun_irradiance * max(dot(normal, u_to_sun), 0.0);
    vec3 indirect = sky + u_sun_irradiance * texelFetch(u_sun_bounce, pixel, 0).rgb;
    bool clipped = texelFetch(u_clipped, pixel, 0).r > 0.0;
    vec3 to_radiance = albedo.rgb * kInvPi;
    float s_without = SunWithout(camera, clipped, to_radiance * (indirect + direct),
                               to_radiance * indirect, visibility_edge.x, visibility_edge.y,
                               albedo.a > 0.0);
    float s_with = (1.0 - in_shadow) * s_without;
    vec3 before = indirect + s_without * direct;
    vec3 after = indirect + s_with * direct;
    bvec3 darkens = lessThan(after, before);
    if (any(darkens) && is_known) {
      is_changed = true;
      vec3 ratio = vec3(darkens.r ? after.r / before.r : 1.0,
                        darkens.g ? after.g / before.g : 1.0,
                        darkens.b ? after.b / before.b : 1.0);
      real = clipped ? to_radiance * after : camera * ratio;
    }
  }
  if (object.a > 0.0) {
    // What a broken camera pixel holds cannot shine through an object's edge.
    vec3 blended = is_known ? object.rgb + (1.0 - object.a) * real : object.rgb / object.a;
    o_colour = vec4(min(blended, vec3(kHalfMax)), 1.0);
  } else if (is_changed) {
    o_colour = vec4(min(real, vec3(kHalfMax)), kScaled);
  } else {
    discard;
  }
}
)";

void BindTexture(int unit, GLenum target, GLuint texture) {
  glActiveTexture(static_cast<GLenum>(GL_TEXTURE0 + unit));
  glBindTexture(target, texture);
}

}  // namespace

CompositePass::CompositePass()
    : target_("composite", GL_RGBA16F, FrameBuffer::DepthStencil::kNone),
      program_("composite", kScreenVertexShader, kFragmentShader),
      no_vertices_(MakeVertexArray()) {}

void CompositePass::Draw(const SurfaceTextures& surface,
                         const LayerLookup& lookup,
                         GLuint object_layer,
                         GLuint shadow_mask,
                         const CompositeLight& light,
                         float gain,
                         int width,
                         int height,
                         const PixelRect& rect) {
  ResetPassState();
  target_.Resize(width, height);
  target_.Bind();
  ScissorTo(rect);
  glClear(GL_COLOR_BUFFER_BIT);
  program_.Use();
  struct Unit {
    const char* name;
    GLenum target;
    GLuint texture;
  };
  const std::array<Unit, 10> units{
      {{"u_camera_radiance", GL_TEXTURE_2D, surface.Camera()},
       {"u_clipped", GL_TEXTURE_2D, surface.Clipped()},
       {"u_object_layer", GL_TEXTURE_2D, object_layer},
       {"u_shadow_mask", GL_TEXTURE_2D, shadow_mask},
       {"u_albedo", GL_TEXTURE_2D, surface.Albedo()},
       {"u_normal", GL_TEXTURE_2D, surface.Normal()},
       {"u_sky_response", GL_TEXTURE_2D_ARRAY, surface.SkyResponse()},
       {"u_sun_bounce", GL_TEXTURE_2D, surface.SunBounce()},
       {"u_sun_visibility", GL_TEXTURE_2D, surface.SunVisibility()},
       {"u_lookup", GL_TEXTURE_2D, lookup.IsIdentity() ? 0 : lookup.Texture()}}};
  for (std::size_t i = 0; i < units.size(); ++i) {
    BindTexture(static_cast<int>(i), units[i].target, units[i].texture);
    program_.Set(units[i].name, static_cast<int>(i));
  }
  program_.Set("u_has_lookup", lookup.IsIdentity() ? 0 : 1);
  program_.Set("u_to_sun", glm::vec3(light.to_sun));
  program_.Set("u_sun_irradiance", light.sun_irradiance);
  program_.Set("u_sky_shapes", static_cast<int>(light.sky_irradiance.size()));
  if (!light.sky_irradiance.empty()) {
    program_.SetArray("u_sky_irradiance",
                      light.sky_irradiance.data(),
                      static_cast<int>(light.sky_irradiance.size()));
  }
  program_.Set("u_gain", gain);
  glBindVertexArray(no_vertices_.Name());
  DrawScreen();
  for (std::size_t i = 0; i < units.size(); ++i) {
    BindTexture(static_cast<int>(i), units[i].target, 0);
  }
  glActiveTexture(GL_TEXTURE0);
}

}  // namespace pleinair

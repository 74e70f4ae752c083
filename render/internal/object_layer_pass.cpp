#include "render/internal/object_layer_pass.h"

#include <cstdint>

#include <glm/vec4.hpp>

#include "render/internal/view_projection.h"

namespace pleinair {
namespace {

constexpr std::string_view kAmbientVertexShader = R"(
layout(location = 0) in vec4 a_position;
layout(location = 2) in vec3 a_diffuse;
layout(location = 3) in vec4 a_specular_alpha;
layout(location = 4) in vec3 a_irradiance;
uniform mat4 u_clip_from_local;
uniform int u_mirrors;
invariant gl_Position;
out vec3 v_radiance;
flat out int v_mirrors;
void main() {
  bool is_glossy = any(greaterThan(a_specular_alpha.rgb, vec3(0.0)));
  v_mirrors = is_glossy ? u_mirrors : 0;
  vec3 albedo = v_mirrors != 0 ? a_diffuse : min(a_diffuse + a_specular_alpha.rgb, vec3(1.0));
  v_radiance = albedo * a_irradiance * 0.318309886;
  gl_Position = u_clip_from_local * a_position;
}
)";

constexpr std::string_view kAmbientFragmentShader = R"(
in vec3 v_radiance;
flat in int v_mirrors;
uniform sampler2D u_mirrored;
uniform ivec4 u_mirrored_rect;  // Lower corner, from this picture's, and size.
uniform int u_samples_per_side;
uniform float u_gain;
out vec4 o_colour;
void main() {
  vec3 radiance = v_radiance;
  if (v_mirrors != 0) {
    ivec2 place = ivec2(gl_FragCoord.xy) / u_samples_per_side - u_mirrored_rect.xy;
    bool is_inside = all(greaterThanEqual(place, ivec2(0))) &&
                     all(lessThan(place, u_mirrored_rect.zw));
    if (is_inside) radiance += u_gain * texelFetch(u_mirrored, place, 0).rgb;
  }
  o_colour = vec4(min(radiance, vec3(65504.0)), 1.0);
}
)";

constexpr std::string_view kSunVertexShader = R"(
layout(location = 0) in vec4 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec3 a_diffuse;
layout(location = 3) in vec4 a_specular_alpha;
uniform mat4 u_clip_from_local;
invariant gl_Position;
out vec3 v_position;
out vec3 v_normal;
flat out vec3 v_diffuse;
flat out vec4 v_specular_alpha;
void main() {
  v_position = a_position.xyz;
  v_normal = a_normal;
  v_diffuse = a_diffuse;
  v_specular_alpha = a_specular_alpha;
  gl_Position = u_clip_from_local * a_position;
}
)";

// GGX with Smith's height-correlated masking (Heitz 2014, "Understanding the masking-shadowing
// function", equation 99) and Schlick's Fresnel term, which ends at 1 only for reflectances that
// real surfaces have (above 2 %), so that k = 0 means none.
//
// The disc widens the lobe by half its radius, in half vectors: a perfect mirror then shows the
// sun's own mean radiance, P / (pi radius^2), and nothing overflows but the format. So does the
// turn of the normal over a sample (Tokuyoshi and Kaplanyan 2019, "Improved geometric specular
// antialiasing", a Gaussian of variance 1 / (2 pi) samples, at most 0.18): a glint smaller than a
// sample keeps its energy, and does not flicker where it moves between samples.
constexpr std::string_view kSunFragmentShader = R"(
in vec3 v_position;
in vec3 v_normal;
flat in vec3 v_diffuse;
flat in vec4 v_specular_alpha;
uniform vec3 u_camera;
uniform vec3 u_to_sun;
uniform vec3 u_irradiance;
uniform float u_angular_radius;
uniform sampler2D u_seen_sun;
uniform ivec4 u_seen_sun_rect;  // Lower corner, from this picture's, and size.
uniform int u_samples_per_side;
uniform int u_shares_per_side;
out vec4 o_colour;

const float kInvPi = 0.318309886;

vec3 Ggx(vec3 n, vec3 v, vec3 l, float n_dot_l, float turn2) {
  float alpha2 = v_specular_alpha.a * v_specular_alpha.a +
                 0.25 * u_angular_radius * u_angular_radius + min(kInvPi * turn2, 0.18);
  float n_dot_v = max(dot(n, v), 1e-4);
  vec3 h = normalize(v + l);
  float n_dot_h = max(dot(n, h), 0.0);
  vec3 n_cross_h = cross(n, h);
  float spread = alpha2 * n_dot_h * n_dot_h + dot(n_cross_h, n_cross_h);
  float density = kInvPi * alpha2 / (spread * spread);
  float visibility = 0.5 / (n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - alpha2) + alpha2) +
                            n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - alpha2) + alpha2));
  float grazing = pow(1.0 - clamp(dot(v, h), 0.0, 1.0), 5.0);
  vec3 k = v_specular_alpha.rgb;
  vec3 fresnel = k + (clamp(50.0 * k, k, vec3(1.0)) - k) * grazing;
  return density * visibility * fresnel;
}

float SeenSun() {
  ivec2 place = ivec2(gl_FragCoord.xy) * u_shares_per_side / u_samples_per_side - u_seen_sun_rect.xy;
  bool is_inside = all(greaterThanEqual(place, ivec2(0))) && all(lessThan(place, u_seen_sun_rect.zw));
  return is_inside ? texelFetch(u_seen_sun, place, 0).r : 1.0;
}

void main() {
  vec3 n = normalize(v_normal);
  if (!gl_FrontFacing) n = -n;
  float n_dot_l = dot(n, u_to_sun);
  vec3 turn_x = dFdx(n);
  vec3 turn_y = dFdy(n);
  float turn2 = dot(turn_x, turn_x) + dot(turn_y, turn_y);
  float seen = SeenSun();
  vec3 radiance = vec3(0.0);
  if (n_dot_l > 0.0 && seen > 0.0) {
    vec3 reflectance = v_diffuse * kInvPi;
    if (any(greaterThan(v_specular_alpha.rgb, vec3(0.0)))) {
      reflectance += Ggx(n, normalize(u_camera - v_position), u_to_sun, n_dot_l, turn2);
    }
    radiance = seen * u_irradiance * n_dot_l * reflectance;
  }
  o_colour = vec4(min(radiance, vec3(65504.0)), 0.0);
}
)";

constexpr std::string_view kMeanFragmentShader = R"(
uniform sampler2D u_samples;
uniform ivec2 u_lower;
uniform int u_samples_per_side;
out vec4 o_colour;
void main() {
  ivec2 first = u_samples_per_side * (ivec2(gl_FragCoord.xy) - u_lower);
  vec4 sum = vec4(0.0);
  for (int y = 0; y < u_samples_per_side; ++y) {
    for (int x = 0; x < u_samples_per_side; ++x) {
      sum += min(texelFetch(u_samples, first + ivec2(x, y), 0), vec4(65504.0));
    }
  }
  o_colour = sum / float(u_samples_per_side * u_samples_per_side);
}
)";

// Binds a texture over part of a picture whose own part starts at `first`.
void BindRect(const ShaderProgram& program,
              const char* texture_uniform,
              const char* rect_uniform,
              const RectTexture& texture,
              const glm::ivec2& first) {
  const PixelRect& rect = texture.Rect();
  program.Set(texture_uniform, 0);
  program.Set(rect_uniform, glm::ivec4(rect.lower - first, rect.upper - rect.lower));
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture.Texture());
}

}  // namespace

int ObjectLayerPass::SamplesPerSide(const PixelRect& rect, int wanted) {
  constexpr std::int64_t kMostSamples = std::int64_t{1} << 22;
  const std::int64_t pixels = std::int64_t{rect.Width()} * rect.Height();
  int side = wanted;
  while (side > 2 && pixels * side * side > kMostSamples) --side;
  return side;
}

ObjectLayerPass::ObjectLayerPass(int samples_per_side)
    : wanted_samples_per_side_(samples_per_side),
      samples_("object samples", GL_RGBA16F, FrameBuffer::DepthStencil::kDepth24Stencil8),
      layer_("object layer", GL_RGBA16F, FrameBuffer::DepthStencil::kNone),
      ambient_program_("object ambient", kAmbientVertexShader, kAmbientFragmentShader),
      sun_program_("object sun", kSunVertexShader, kSunFragmentShader),
      mean_program_("object samples' mean", kScreenVertexShader, kMeanFragmentShader),
      no_vertices_(MakeVertexArray()) {}

void ObjectLayerPass::Draw(const LayerView& view,
                           SceneGeometry& scene,
                           const LayerSun& sun,
                           const ShadowVolumes* object_volumes,
                           const ShadowVolumes* real_volumes,
                           const LayerLight& light,
                           VolumeStencil& stencil) {
  const PixelRect& rect = view.object_rect;
  ResetPassState();
  const bool is_resized = layer_.Resize(view.intrinsics.width_px, view.intrinsics.height_px);
  if (is_resized || !(drawn_rect_ == rect)) {
    layer_.Bind();
    glClear(GL_COLOR_BUFFER_BIT);
    drawn_rect_ = rect;
  }
  if (rect.Empty()) return;
  DrawSamples(view, scene, sun, object_volumes, real_volumes, light, stencil);

  ResetPassState();
  layer_.Bind();
  ScissorTo(rect);
  mean_program_.Use();
  mean_program_.Set("u_samples", 0);
  mean_program_.Set("u_lower", rect.lower);
  mean_program_.Set("u_samples_per_side", SamplesPerSide(rect, wanted_samples_per_side_));
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, samples_.ColourTexture());
  glBindVertexArray(no_vertices_.Name());
  DrawScreen();
  glBindTexture(GL_TEXTURE_2D, 0);
}

void ObjectLayerPass::DrawSamples(const LayerView& view,
                                  SceneGeometry& scene,
                                  const LayerSun& sun,
                                  const ShadowVolumes* object_volumes,
                                  const ShadowVolumes* real_volumes,
                                  const LayerLight& light,
                                  VolumeStencil& stencil) {
  const PixelRect& rect = view.object_rect;
  const int side = SamplesPerSide(rect, wanted_samples_per_side_);
  const PixelRect sample_rect{{0, 0}, {side * rect.Width(), side * rect.Height()}};
  samples_.Reserve(sample_rect.Width(), sample_rect.Height());
  samples_.Bind();
  glViewport(0, 0, sample_rect.Width(), sample_rect.Height());
  ScissorTo(sample_rect);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  const glm::dmat4 rect_from_local =
      ClipOfRect(view.intrinsics, rect.lower, rect.upper) * view.clip_from_local;
  const glm::mat4 clip_from_local(rect_from_local);

  // What hides: real surfaces, seen from either side.
  glEnable(GL_DEPTH_TEST);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  stencil.DrawSurface(scene.PhantomBuffers(), clip_from_local);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);

  glDepthFunc(GL_LEQUAL);  // On a real surface of the same depth the object wins.
  ambient_program_.Use();
  ambient_program_.Set("u_clip_from_local", clip_from_local);
  ambient_program_.Set("u_mirrors", light.mirrors ? 1 : 0);
  ambient_program_.Set("u_samples_per_side", side);
  ambient_program_.Set("u_gain", light.gain);
  BindRect(ambient_program_, "u_mirrored", "u_mirrored_rect", light.mirrored, rect.lower);
  scene.ShadedObjects().Draw();

  if (!sun.is_shining) return;
  if (object_volumes != nullptr && real_volumes != nullptr) {
    // All casters are in the depth buffer, so that no cap lies in front of what is visible.
    stencil.Begin(clip_from_local, glm::vec4(rect_from_local * glm::dvec4(-sun.to_sun, 0.0)));
    stencil.Draw(scene.ObjectBuffers(), *object_volumes, VolumeStencil::Caps::kNeverInFront);
    stencil.Draw(scene.PhantomBuffers(), *real_volumes, VolumeStencil::Caps::kNeverInFront);
    stencil.Finish();
  }
  // Each sample takes the sun once, also where faces are doubled.
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_EQUAL, 0, 0xff);
  glStencilOp(GL_KEEP, GL_KEEP, GL_INCR);
  scene.ObjectsAsCaster().SidesThatMayBeSunlit(sun.to_sun, sunlit_sides_);
  scene.ShadedObjects().UploadSunlitTriangles(sunlit_sides_);
  glDepthFunc(GL_EQUAL);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glEnable(GL_CULL_FACE);
  sun_program_.Use();
  sun_program_.Set("u_clip_from_local", clip_from_local);
  sun_program_.Set("u_camera", view.camera_centre_local);
  sun_program_.Set("u_to_sun", glm::vec3(sun.to_sun));
  sun_program_.Set("u_irradiance", sun.irradiance);
  sun_program_.Set("u_angular_radius", static_cast<float>(sun.angular_radius_rad));
  constexpr int kShareSide = ObjectSunShare::kSamplesPerSide;
  BindRect(sun_program_, "u_seen_sun", "u_seen_sun_rect", light.seen_sun, kShareSide * rect.lower);
  sun_program_.Set("u_samples_per_side", side);
  sun_program_.Set("u_shares_per_side", kShareSide);
  glCullFace(GL_BACK);
  scene.ShadedObjects().DrawTrianglesWithFrontInSun();
  glCullFace(GL_FRONT);
  scene.ShadedObjects().DrawTrianglesWithBackInSun();
  glBindTexture(GL_TEXTURE_2D, 0);
}

}  // namespace pleinair

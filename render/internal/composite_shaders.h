// Shaders of CompositePass. For formulas see compositor.h, real_sun.h and relit_pixel.h.
#pragma once

#include <string_view>

namespace pleinair {

// Layers at a camera pixel, also behind a lens with distortion.
inline constexpr std::string_view kLookupShader = R"(
uniform sampler2D u_object_layer;
uniform sampler2D u_lookup;
uniform int u_has_lookup;

// The value at a place between texels; zero outside. A GPU's own filter may have weights of only
// eight bits, which show at edges.
vec4 Between(sampler2D layer, vec2 place) {
  ivec2 size = textureSize(layer, 0);
  bool is_inside = all(greaterThan(place, vec2(0.0))) && all(lessThan(place, vec2(size)));
  if (!is_inside) return vec4(0.0);
  vec2 corner = floor(place - 0.5);
  vec2 share = place - 0.5 - corner;
  ivec2 low = max(ivec2(corner), ivec2(0));
  ivec2 high = min(ivec2(corner) + 1, size - 1);
  return mix(mix(texelFetch(layer, low, 0), texelFetch(layer, ivec2(high.x, low.y), 0), share.x),
             mix(texelFetch(layer, ivec2(low.x, high.y), 0), texelFetch(layer, high, 0), share.x),
             share.y);
}

// The layers' value at a camera pixel.
vec4 LayerAt(sampler2D layer, ivec2 pixel) {
  if (u_has_lookup == 0) return texelFetch(layer, pixel, 0);
  return Between(layer, texelFetch(u_lookup, pixel, 0).xy);
}
)";

// Find pixels in a new shadow, and those whose other light changes, for the stencil. Relighting
// costs some ten times a texture fetch, in software for every pixel that is drawn, so that only
// these are relit.
inline constexpr std::string_view kShadowedShader = R"(
void main() {
  if (!(ShadowAt(ivec2(gl_FragCoord.xy)) > 0.0)) discard;
}
)";
inline constexpr std::string_view kChangedShader = R"(
void main() {
  if (ChangeAt(ivec2(gl_FragCoord.xy)) == vec3(0.0)) discard;
}
)";

// Change of a pixel's irradiance beside the sun's shadow.
inline constexpr std::string_view kChangeShader = R"(
uniform sampler2D u_change;
uniform ivec4 u_change_rect;  // Lower corner and size.
vec3 ChangeAt(ivec2 pixel) {
  ivec2 place = pixel - u_change_rect.xy;
  bool is_inside = all(greaterThanEqual(place, ivec2(0))) &&
                   all(lessThan(place, u_change_rect.zw));
  return is_inside ? texelFetch(u_change, place, 0).rgb : vec3(0.0);
}
)";

// A pixel's share of new shadow. Where given, it is the hidden share of the disc, with the camera's
// blur over pixels that no object covers. Else the mask has lit or shaded at a pixel's centre, and
// its mean over the pixel and half of each neighbour is used (a tent filter): an approximation of
// lens and disc.
inline constexpr std::string_view kShadowShareShader = R"(
uniform sampler2D u_shadow_mask;
uniform sampler2D u_hidden_sun;
uniform ivec4 u_hidden_sun_rect;  // Lower corner and size.
uniform int u_blur_reach;
uniform float u_blur_weights[25];  // BlurKernel::kMostReachPx and the middle.
float HiddenAt(ivec2 pixel) {
  ivec2 place = pixel - u_hidden_sun_rect.xy;
  bool is_inside = all(greaterThanEqual(place, ivec2(0))) &&
                   all(lessThan(place, u_hidden_sun_rect.zw));
  return is_inside ? texelFetch(u_hidden_sun, place, 0).r : 0.0;
}
float BlurredHiddenAt(ivec2 pixel) {
  if (u_blur_reach == 0) return HiddenAt(pixel);
  ivec2 last = (u_has_lookup != 0 ? textureSize(u_lookup, 0) : textureSize(u_object_layer, 0)) - 1;
  float sum = 0.0;
  float weights = 0.0;
  for (int dy = -u_blur_reach; dy <= u_blur_reach; ++dy) {
    for (int dx = -u_blur_reach; dx <= u_blur_reach; ++dx) {
      ivec2 at = clamp(pixel + ivec2(dx, dy), ivec2(0), last);
      float weight = u_blur_weights[abs(dx)] * u_blur_weights[abs(dy)] *
                     (1.0 - LayerAt(u_object_layer, at).a);
      sum += weight * HiddenAt(at);
      weights += weight;
    }
  }
  return weights > 1e-4 ? sum / weights : HiddenAt(pixel);
}
float ShadowAt(ivec2 pixel) {
  if (u_hidden_sun_rect.z > 0) return BlurredHiddenAt(pixel);
  vec2 place = u_has_lookup != 0 ? texelFetch(u_lookup, pixel, 0).xy : vec2(pixel);
  ivec2 size = textureSize(u_shadow_mask, 0);
  float sum = 0.0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      float weight = (dx == 0 ? 0.5 : 0.25) * (dy == 0 ? 0.5 : 0.25);
      vec2 at = place + vec2(dx, dy);
      if (u_has_lookup != 0) {
        sum += weight * Between(u_shadow_mask, at).r;
      } else if (all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(size)))) {
        sum += weight * texelFetch(u_shadow_mask, ivec2(at), 0).r;
      }
    }
  }
  return sum;
}
)";

// The common beginning of the following two.
inline constexpr std::string_view kCommonShader = R"(
uniform sampler2D u_camera_radiance;
uniform float u_gain;
out vec4 o_colour;

const float kHalfMax = 65504.0;
const float kScaled = 128.0 / 255.0;

// In the layers' units; alpha: whether it is clipped.
vec4 CameraAt(ivec2 pixel) {
  return texelFetch(u_camera_radiance, pixel, 0) * vec4(vec3(u_gain), 1.0);
}

bool IsKnown(vec3 camera) {
  return all(greaterThanEqual(camera, vec3(0.0))) && all(lessThan(camera, vec3(1e37)));
}

// What a broken camera pixel holds cannot shine through an object's edge.
vec4 Covered(vec4 object, vec3 real, bool is_known) {
  vec3 blended = is_known ? object.rgb + (1.0 - object.a) * real : object.rgb / object.a;
  return vec4(min(blended, vec3(kHalfMax)), 1.0);
}
)";

// Objects over pixels that are otherwise the camera's own.
inline constexpr std::string_view kCoverShader = R"(
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 object = LayerAt(u_object_layer, pixel);
  vec3 camera = CameraAt(pixel).rgb;
  if (!(object.a > 0.0)) discard;
  o_colour = Covered(object, camera, IsKnown(camera));
}
)";

inline constexpr std::string_view kRelightShader = R"(
uniform sampler2D u_albedo;
uniform sampler2D u_normal;
uniform sampler2DArray u_sky_response;
uniform sampler2D u_sun_bounce;
uniform sampler2D u_sun_visibility;
uniform vec3 u_to_sun;
uniform vec3 u_sun_irradiance;
uniform vec3 u_sky_irradiance[128];
uniform int u_sky_shapes;

const float kInvPi = 0.318309886;

float Median(vec3 v) { return max(min(v.r, v.g), min(max(v.r, v.g), v.b)); }

// SunSeenWithout of real_sun.h, whose constants stand before. Values at a pixel are its place
// between shade (0) and sun (1), and its radiance; -1: unknown.
struct Predictions {
  vec3 least;
  vec3 lit;
  vec3 log_from;
  vec3 per_log;
  vec3 log_agrees_from;
};
// In place of a bound's logarithm where a channel has no sun: the mesh alone decides.
const float kNoLightLog = 1e9;
Predictions PredictionsOf(vec3 lit, vec3 shaded, float sigma, float of_mesh) {
  Predictions p;
  p.least = max(1e-6 * lit, vec3(1e-30));
  p.lit = max(lit, p.least);
  vec3 log_shaded = log(max(shaded, p.least));
  vec3 spread = log(p.lit / max(shaded, p.least));
  for (int c = 0; c < 3; ++c) {
    float middle = log_shaded[c] + 0.5 * spread[c];
    float s = spread[c];
    if (s > 0.0) {
      float even = middle - sigma * sigma * of_mesh / s;
      float width_half = max(0.5 * s - kSurelySigmas * sigma, kLeastHalfBetween);
      float sure = sigma * sigma * kMeshLogOdds / s;
      p.log_from[c] = even - width_half;
      p.per_log[c] = 0.5 / width_half;
      p.log_agrees_from[c] = of_mesh > 0.0 ? max(even + width_half, middle + sure)
                                           : min(even - width_half, middle - sure);
    } else {
      p.log_from[c] = p.log_agrees_from[c] = of_mesh > 0.0 ? -kNoLightLog : kNoLightLog;
      p.per_log[c] = 1.0;
    }
  }
  return p;
}
vec3 LogOf(vec3 observed, bool clipped, Predictions p) {
  // A clipped value is a lower bound: it may be as bright as lit.
  return log(max(observed, clipped ? p.lit : p.least));
}
vec2 PlaceOf(vec3 observed, bool clipped, Predictions p) {
  vec3 place = (LogOf(observed, clipped, p) - p.log_from) * p.per_log;
  return vec2(clamp(Median(place), 0.0, 1.0), dot(observed, vec3(1.0)));
}
vec2 MedianOf(vec2 a, vec2 b, vec2 c) {
  bool are_known = min(a.y, min(b.y, c.y)) >= 0.0;
  return vec2(Median(vec3(a.x, b.x, c.x)), are_known ? Median(vec3(a.y, b.y, c.y)) : -1.0);
}
void CompareSides(vec2 one, vec2 other, float own, inout float contrast, inout float share) {
  if (one.y < 0.0 || other.y < 0.0) return;
  if ((one.x > 0.5) == (other.x > 0.5) || abs(one.x - other.x) < kLeastEdgeStep) return;
  float shaded = other.x > one.x ? one.y : other.y;
  float lit = other.x > one.x ? other.y : one.y;
  if (!(lit - shaded > contrast)) return;
  contrast = lit - shaded;
  share = clamp((own - shaded) / contrast, 0.0, 1.0);
}
struct Surface {
  vec3 normal;
  vec4 albedo;  // Alpha: whether it was measured.
  vec3 lit;  // Radiance in the sun and in shade.
  vec3 shaded;
  float model;  // Visible share of the sun past the mesh.
  float edge_distance;
};
float SunWithout(ivec2 pixel, vec3 observed, bool clipped, Surface surface) {
  vec4 albedo = surface.albedo;
  float sun = surface.model > 0.0 ? surface.model : 1.0;
  float sigma = albedo.a > 0.0 ? kSharedSigmaMeasured : kSharedSigmaGuessed;
  float trust = clamp(surface.edge_distance / kTrustedEdgeDistancePx, 0.0, 1.0);
  float of_mesh = (2.0 * surface.model - 1.0) * kMeshLogOdds * trust;
  Predictions p = PredictionsOf(surface.lit, surface.shaded, sigma, of_mesh);
  bool is_lit_by_mesh = of_mesh > 0.0;
  bool agrees_with_mesh =
      of_mesh != 0.0 &&
      (Median(LogOf(observed, clipped, p) - p.log_agrees_from) > 0.0) == is_lit_by_mesh;
  if (agrees_with_mesh) {
    if (!is_lit_by_mesh) return 0.0;
    float surely_lit = dot(mix(surface.shaded, surface.lit, kSurelyLit), vec3(1.0));
    if (dot(observed, vec3(1.0)) >= surely_lit) return sun;
  }
  vec2 own = PlaceOf(observed, clipped, p);
  vec2 around[9];  // Rows of three.
  for (int i = 0; i < 9; ++i) {
    around[i] = i == 4 ? own : vec2(own.x, -1.0);
    if (i == 4) continue;
    ivec2 place = pixel + int(kAroundPx) * (ivec2(i % 3, i / 3) - 1);
    if (any(lessThan(place, ivec2(0))) ||
        any(greaterThanEqual(place, textureSize(u_camera_radiance, 0)))) continue;
    vec4 camera = CameraAt(place);
    if (!(dot(surface.normal, texelFetch(u_normal, place, 0).rgb) > kOnePlaneCosine)) continue;
    if (!IsKnown(camera.rgb)) continue;
    vec3 other = max(texelFetch(u_albedo, place, 0).rgb, vec3(kLeastAlbedo));
    around[i] = PlaceOf(camera.rgb * (max(albedo.rgb, vec3(kLeastAlbedo)) / other),
                        camera.a > 0.0, p);
  }
  vec2 above = MedianOf(around[0], around[1], around[2]);
  vec2 below = MedianOf(around[6], around[7], around[8]);
  float contrast = 0.0;
  float share = -1.0;
  CompareSides(MedianOf(around[0], around[3], around[6]),
               MedianOf(around[2], around[5], around[8]), own.y, contrast, share);
  CompareSides(above, below, own.y, contrast, share);
  if (min(share, 1.0 - share) >= kLeastEdgeShare) return share;
  if (agrees_with_mesh) return sun;
  float at = Median(vec3(above.x, MedianOf(around[3], around[4], around[5]).x, below.x));
  float left = dot(max(surface.shaded, p.least), vec3(1.0)) / dot(p.lit, vec3(1.0));
  if (at > 0.0 && at < 1.0 && left <= kEvenLeft) at = (pow(left, -at) - 1.0) / (1.0 / left - 1.0);
  return sun * at;
}

// ReflectedOf and Relit of relit_pixel.cpp.
vec3 ReflectedOf(vec3 camera, vec3 before, vec3 albedo, bool measured) {
  vec3 seen = vec3(0.0);
  for (int c = 0; c < 3; ++c) {
    if (camera[c] > 0.0) {
      seen[c] = camera[c] < kInvPi * before[c] ? camera[c] / before[c] : kInvPi;
    }
  }
  vec3 model = kInvPi * max(albedo, vec3(kLeastAlbedo));
  float sigma = measured ? kSigmaMeasured : kSigmaGuessed;
  return min(seen, exp(kMostAlbedoSigmas * sigma) * min(Median(seen / model), 1.0) * model);
}
vec3 Relit(vec3 camera, bool clipped, vec4 albedo, vec3 before, vec3 after, out bool is_relit) {
  vec3 added = after - before;
  bvec3 is_changed = greaterThan(abs(added), kLeastRelitChange * before);
  is_relit = any(is_changed);
  vec3 reflected = ReflectedOf(camera, before, albedo.rgb, albedo.a > 0.0);
  vec3 without = clipped ? max(camera, kInvPi * albedo.rgb * before) : camera;
  vec3 relit = camera;
  for (int c = 0; c < 3; ++c) {
    if (is_changed[c]) {
      relit[c] = added[c] > 0.0 ? camera[c] + reflected[c] * added[c]
                                : min(without[c] * (after[c] / before[c]), camera[c]);
    }
  }
  return relit;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float in_shadow = ShadowAt(pixel);
  vec4 object = LayerAt(u_object_layer, pixel);
  vec4 camera_clipped = CameraAt(pixel);
  vec3 camera = camera_clipped.rgb;
  bool is_known = IsKnown(camera);
  vec3 sky = vec3(0.0);
  for (int k = 0; k < u_sky_shapes; ++k) {
    sky += u_sky_irradiance[k] * texelFetch(u_sky_response, ivec3(pixel, k), 0).rgb;
  }
  vec3 normal = texelFetch(u_normal, pixel, 0).rgb;
  vec2 visibility_edge = texelFetch(u_sun_visibility, pixel, 0).rg;
  vec4 albedo = texelFetch(u_albedo, pixel, 0);
  vec3 direct = u_sun_irradiance * max(dot(normal, u_to_sun), 0.0);
  vec3 indirect = sky + u_sun_irradiance * texelFetch(u_sun_bounce, pixel, 0).rgb;
  bool clipped = camera_clipped.a > 0.0;
  vec3 to_radiance = albedo.rgb * kInvPi;
  Surface surface = Surface(normal, albedo, to_radiance * (indirect + direct),
                            to_radiance * indirect, visibility_edge.x, visibility_edge.y);
  float s_without = SunWithout(pixel, camera, clipped, surface);
  float s_with = (1.0 - in_shadow) * s_without;
  vec3 before = indirect + s_without * direct;
  // Hidden light is gathered with other rays than all of it: the difference may fall below zero.
  vec3 after = max(indirect + u_gain * ChangeAt(pixel), vec3(0.0)) + s_with * direct;
  bool is_relit;
  vec3 real = Relit(camera, clipped, albedo, before, after, is_relit);
  // There is no surface without a normal.
  is_relit = is_relit && is_known && normal != vec3(0.0);
  if (!is_relit) real = camera;
  if (object.a > 0.0) {
    o_colour = Covered(object, real, is_known);
  } else {
    o_colour = is_relit ? vec4(min(real, vec3(kHalfMax)), kScaled) : vec4(0.0);
  }
}
)";

}  // namespace pleinair

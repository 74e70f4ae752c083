// Shaders of ObjectLayerPass. For formulas see its header.
#pragma once

#include <string_view>

namespace pleinair {

inline constexpr std::string_view kObjectAmbientVertexShader = R"(
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

// The pixel and its part where a sample lies, see SampleLattice: pixels have `parts_per_side`. One
// in the middle of a pixel of four goes to the last: where side is 4 that moves light by 0.015 px.
// Whole numbers in floats, half of one off what they are divided by: integers divide slowly.
inline constexpr std::string_view kObjectPlaceOfSample = R"(
uniform ivec3 u_lattice;  // Side, turn, and the pixels' width.
ivec2 PlaceOfSample(int parts_per_side) {
  vec3 lattice = vec3(u_lattice);
  vec2 twice = 2.0 * (gl_FragCoord.xy - vec2(0.0, lattice.y * lattice.z));
  vec2 twice_place = vec2(lattice.x * twice.x - lattice.y * twice.y,
                          lattice.y * twice.x + lattice.x * twice.y);
  float twice_count = 2.0 * (lattice.x * lattice.x + lattice.y);
  return ivec2(floor((float(parts_per_side) * twice_place + 0.5) / twice_count));
}
)";

// What surfaces around mirror into the picture.
inline constexpr std::string_view kObjectMirrored = R"(
uniform sampler2D u_mirrored;
uniform ivec4 u_mirrored_rect;  // Lower corner, from this picture's, and size.
uniform float u_gain;
vec3 Mirrored() {
  ivec2 place = PlaceOfSample(1) - u_mirrored_rect.xy;
  bool is_inside = all(greaterThanEqual(place, ivec2(0))) &&
                   all(lessThan(place, u_mirrored_rect.zw));
  return is_inside ? u_gain * texelFetch(u_mirrored, place, 0).rgb : vec3(0.0);
}
)";

inline constexpr std::string_view kObjectAmbientFragmentShader = R"(
in vec3 v_radiance;
flat in int v_mirrors;
out vec4 o_colour;
void main() {
  vec3 radiance = v_radiance;
  if (v_mirrors != 0) radiance += Mirrored();
  o_colour = vec4(min(radiance, vec3(65504.0)), 1.0);
}
)";

inline constexpr std::string_view kObjectSunVertexShader = R"(
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

// Put before kObjectSunFragmentShader, where a triangle is of one colour.
inline constexpr std::string_view kObjectMaterial = R"(
flat in vec3 v_diffuse;
flat in vec4 v_specular_alpha;
void FindMaterial(out vec3 diffuse, out vec4 specular_alpha) {
  diffuse = v_diffuse;
  specular_alpha = v_specular_alpha;
}
)";

// GGX with Smith's height-correlated masking (Heitz 2014, "Understanding the masking-shadowing
// function", equation 99) and the Fresnel term of Schlick 1994. That term ends at 1 only for
// reflectances of real surfaces (above 2 %), so that k = 0 means none.
//
// The disc widens the lobe by half its radius, in half vectors: a perfect mirror then shows the
// sun's own mean radiance, P / (pi radius^2), and nothing overflows but the format. The turn of the
// normal over a sample widens it too (Tokuyoshi and Kaplanyan 2019, "Improved geometric specular
// antialiasing", a Gaussian of variance 1 / (2 pi) samples, at most 0.18). So a glint smaller than
// a sample keeps its energy, and does not flicker where it moves between samples. The widening must
// not change the lobe's tail. The material's own share of the widened lobe, alpha^2 before over
// after, stays GGX, with the material's tail. The rest is a Gaussian (Beckmann's lobe) of that
// width, which keeps the peak of a GGX of that width.
inline constexpr std::string_view kObjectSunFragmentShader = R"(
in vec3 v_position;
in vec3 v_normal;
uniform vec3 u_camera;
uniform vec3 u_to_sun;
uniform vec3 u_irradiance;
uniform float u_angular_radius;
uniform sampler2D u_seen_sun;
uniform ivec4 u_seen_sun_rect;  // Lower corner, from this picture's, and size.
uniform int u_shares_per_side;
out vec4 o_colour;

const float kInvPi = 0.318309886;

vec3 Ggx(vec4 specular_alpha, vec3 n, vec3 v, vec3 l, float n_dot_l, float turn2) {
  float own_alpha2 = specular_alpha.a * specular_alpha.a;
  float alpha2 =
      own_alpha2 + 0.25 * u_angular_radius * u_angular_radius + min(kInvPi * turn2, 0.18);
  float n_dot_v = max(dot(n, v), 1e-4);
  vec3 h = normalize(v + l);
  float n_dot_h = max(dot(n, h), 0.0);
  vec3 n_cross_h = cross(n, h);
  float cos2 = max(n_dot_h * n_dot_h, 1e-8);
  float slope2 = dot(n_cross_h, n_cross_h) / (cos2 * alpha2);  // By the lobe's width.
  float of_ggx = own_alpha2 / alpha2;
  float density = kInvPi / (alpha2 * cos2 * cos2) *
                  (of_ggx / ((1.0 + slope2) * (1.0 + slope2)) + (1.0 - of_ggx) * exp(-slope2));
  float visibility = 0.5 / (n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - alpha2) + alpha2) +
                            n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - alpha2) + alpha2));
  float grazing = pow(1.0 - clamp(dot(v, h), 0.0, 1.0), 5.0);
  vec3 k = specular_alpha.rgb;
  vec3 fresnel = k + (clamp(50.0 * k, k, vec3(1.0)) - k) * grazing;
  return density * visibility * fresnel;
}

float SeenSun() {
  ivec2 place = PlaceOfSample(u_shares_per_side) - u_seen_sun_rect.xy;
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
  vec3 diffuse;
  vec4 specular_alpha;
  FindMaterial(diffuse, specular_alpha);
  float seen = SeenSun();
  vec3 radiance = vec3(0.0);
  if (n_dot_l > 0.0 && seen > 0.0) {
    vec3 reflectance = diffuse * kInvPi;
    if (any(greaterThan(specular_alpha.rgb, vec3(0.0)))) {
      reflectance += Ggx(specular_alpha, n, normalize(u_camera - v_position), u_to_sun, n_dot_l, turn2);
    }
    radiance = seen * u_irradiance * n_dot_l * reflectance;
  }
  o_colour = vec4(min(radiance, vec3(65504.0)), 0.0);
}
)";

inline constexpr std::string_view kObjectTriangleVertexShader = R"(
layout(location = 0) in vec4 a_position;
uniform mat4 u_clip_from_local;
invariant gl_Position;
void main() { gl_Position = u_clip_from_local * a_position; }
)";

// Number of the nearest triangle, from 1.
inline constexpr std::string_view kObjectTriangleFragmentShader = R"(
uniform int u_first_triangle;
out uint o_number;
void main() { o_number = uint(gl_PrimitiveID + u_first_triangle) + 1u; }
)";

// The mean of the samples, if there are any, and of what was summed without them.
inline constexpr std::string_view kObjectMeanFragmentShader = R"(
uniform sampler2D u_samples;
uniform sampler2D u_from_vertices;
uniform int u_has_from_vertices;
uniform ivec2 u_lower;
uniform ivec3 u_lattice;     // Side, turn, and the pixels' width.
uniform int u_sample_count;  // A pixel's; 0: none.
uniform vec2 u_offsets[65];  // SampleLattice::Offsets(), kMostPerPixel at most.
out vec4 o_colour;
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy) - u_lower;
  ivec2 first = u_lattice.x * place +
                u_lattice.y * ivec2(place.y, u_lattice.z - place.x);
  vec4 sum = vec4(0.0);
  for (int i = 0; i < u_sample_count; ++i) {
    sum += min(texelFetch(u_samples, first + ivec2(u_offsets[i]), 0), vec4(65504.0));
  }
  vec4 mean = sum / float(max(u_sample_count, 1));
  if (u_has_from_vertices != 0) mean += texelFetch(u_from_vertices, place, 0);
  o_colour = min(mean, vec4(65504.0));
}
)";

}  // namespace pleinair

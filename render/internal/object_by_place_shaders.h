// Shaders of ObjectLayerPass for materials by place; see object_layer_shaders.h.
#pragma once

#include <string_view>

namespace pleinair {

// For all of the passes: each uses the outputs that it needs.
inline constexpr std::string_view kByPlaceVertexShader = R"(
layout(location = 0) in vec4 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 3) in vec4 a_specular_alpha;
layout(location = 4) in vec3 a_irradiance;
layout(location = 5) in vec2 a_texture_uv;
layout(location = 6) in vec4 a_colour;
uniform mat4 u_clip_from_local;
invariant gl_Position;
out vec3 v_position;
out vec3 v_normal;
out vec3 v_irradiance;
out vec2 v_texture_uv;
out vec4 v_colour;
flat out float v_alpha;
void main() {
  v_position = a_position.xyz;
  v_normal = a_normal;
  v_irradiance = a_irradiance;
  v_texture_uv = a_texture_uv;
  v_colour = a_colour;
  v_alpha = a_specular_alpha.a;
  gl_Position = u_clip_from_local * a_position;
}
)";

// TexturedMaterial and Texture, on the device. Levels are mixed here: software takes a short cut
// where it is asked to. Placed before the passes' own code. It must be called before any branch,
// since it reads neighbouring fragments; it also discards cut-out fragments.
inline constexpr std::string_view kByPlaceMaterial = R"(
in vec2 v_texture_uv;
in vec4 v_colour;
flat in float v_alpha;  // GGX.
uniform sampler2D u_picture;
uniform int u_last_level;  // -1: there is no picture.
uniform vec4 u_base_colour;
uniform float u_metallic;
uniform vec3 u_dielectric_reflectance;
uniform float u_max_albedo;
uniform float u_alpha_cutoff;

vec4 PictureHere() {
  vec2 size = vec2(textureSize(u_picture, 0));
  vec2 across = dFdx(v_texture_uv) * size;
  vec2 down = dFdy(v_texture_uv) * size;
  float length2 = max(dot(across, across), dot(down, down));
  float level = clamp(0.5 * log2(clamp(length2, 1e-30, 1e30)), 0.0, float(u_last_level));
  float lower = floor(level);
  vec4 fine = textureLod(u_picture, v_texture_uv, lower);
  float share = level - lower;
  return share > 0.0 ? mix(fine, textureLod(u_picture, v_texture_uv, lower + 1.0), share) : fine;
}

void FindMaterial(out vec3 diffuse, out vec4 specular_alpha) {
  vec4 colour = u_base_colour * v_colour;
  if (u_last_level >= 0) colour *= PictureHere();
  if (colour.a < u_alpha_cutoff) discard;
  diffuse = clamp((1.0 - u_metallic) * colour.rgb, vec3(0.0), vec3(u_max_albedo));
  vec3 specular = mix(u_dielectric_reflectance, colour.rgb, u_metallic);
  specular_alpha = vec4(clamp(specular, vec3(0.0), vec3(1.0)), v_alpha);
}
)";

inline constexpr std::string_view kByPlaceAmbientFragmentShader = R"(
in vec3 v_irradiance;
uniform int u_mirrors;
out vec4 o_colour;
void main() {
  vec3 diffuse;
  vec4 specular_alpha;
  FindMaterial(diffuse, specular_alpha);
  vec3 albedo = u_mirrors != 0 ? diffuse : min(diffuse + specular_alpha.rgb, vec3(1.0));
  vec3 radiance = albedo * v_irradiance * 0.318309886;
  if (u_mirrors != 0) radiance += Mirrored();
  o_colour = vec4(min(radiance, vec3(65504.0)), 1.0);
}
)";

// As kObjectTriangleFragmentShader, where the texture is not cut out.
inline constexpr std::string_view kByPlaceTriangleFragmentShader = R"(
uniform int u_first_triangle;
out uint o_number;
void main() {
  vec3 diffuse;
  vec4 specular_alpha;
  FindMaterial(diffuse, specular_alpha);
  o_number = uint(gl_PrimitiveID + u_first_triangle) + 1u;
}
)";

}  // namespace pleinair

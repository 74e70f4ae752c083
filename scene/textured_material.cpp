#include "scene/textured_material.h"

#include <algorithm>
#include <vector>

#include <glm/common.hpp>

#include "scene/internal/material_list.h"

namespace pleinair {
namespace {

glm::vec3 MeanOfVertices(const TriangleColours& colours) {
  const auto& [a, b, c] = colours.vertex_colour;
  return a == b && b == c ? glm::vec3(a) : glm::vec3(a + b + c) / 3.0f;
}

}  // namespace

TexturedMaterial::Reflectances TexturedMaterial::Of(const glm::vec3& colour) const {
  const glm::vec3 here = base_colour * colour;
  return {glm::clamp((1.0f - metallic) * here, glm::vec3(0.0f), glm::vec3(kMaxAlbedo)),
          glm::clamp(
              glm::mix(dielectric_reflectance, here, metallic), glm::vec3(0.0f), glm::vec3(1.0f))};
}

Material TexturedMaterial::WithColour(const glm::vec3& colour) const {
  const Reflectances here = Of(colour);
  Material material;
  material.name = name;
  material.diffuse_albedo = here.diffuse_albedo;
  material.specular_reflectance = here.specular_reflectance;
  material.roughness = roughness;
  return material;
}

Material TexturedMaterial::Mean() const {
  return WithColour(texture ? texture->Mean() : glm::vec3(1.0f));
}

bool TexturedMaterial::ExceedsLimits() const {
  const Material limited = Mean();
  const glm::vec3 mean = base_colour * (texture ? texture->Mean() : glm::vec3(1.0f));
  return limited.diffuse_albedo != (1.0f - metallic) * mean ||
         limited.specular_reflectance != glm::mix(dielectric_reflectance, mean, metallic);
}

TexturedMaterial::Reflectances TexturedMaterial::Brightest() const {
  return Of(texture ? glm::vec3(texture->Largest()) : glm::vec3(1.0f));
}

bool TexturedMaterial::IsGlossy() const {
  const glm::vec3 k = Brightest().specular_reflectance;
  return std::max({k.r, k.g, k.b}) > 0.0f;
}

glm::vec4 TexturedMaterial::ColourAt(const glm::vec2& uv,
                                     float level,
                                     const glm::vec4& vertex_colour) const {
  return texture ? vertex_colour * texture->At(uv, level, wraps) : vertex_colour;
}

glm::vec3 TexturedMaterial::MeanOver(const TriangleColours& colours) const {
  if (!texture || texture->Least() == texture->Largest()) return MeanAnywhere(colours);
  const auto of = alpha_cutoff > 0.0f ? Texture::Of::kWhatIsThere : Texture::Of::kAll;
  return MeanOfVertices(colours) * texture->MeanOver(colours.texture_uv, wraps, of);
}

glm::vec3 TexturedMaterial::MeanAnywhere(const TriangleColours& colours) const {
  return texture ? MeanOfVertices(colours) * texture->Mean() : MeanOfVertices(colours);
}

bool TexturedMaterial::IsEvenOver(const TriangleColours& colours) const {
  const auto& [a, b, c] = colours.vertex_colour;
  const bool is_one = a == b && b == c && (!texture || texture->Least() == texture->Largest());
  const float least_alpha =
      base_alpha * std::min({a.a, b.a, c.a}) * (texture ? texture->Least().a : 1.0f);
  return is_one && !(least_alpha < alpha_cutoff);
}

void TakeMeansOverTriangles(Mesh& mesh) {
  const auto is_by_place = [](const Material& material) { return material.by_place != nullptr; };
  if (std::none_of(mesh.materials.begin(), mesh.materials.end(), is_by_place)) return;
  MaterialList list;
  constexpr std::uint32_t kNotYet = 0xffffffffu;
  std::vector<std::uint32_t> number_of(mesh.materials.size(), kNotYet);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::uint32_t& number = mesh.triangle_material[t];
    const Material& material = mesh.materials[number];
    if (material.by_place) {
      number = list.Index(
          material.by_place, material.by_place->MeanOver(mesh.triangle_colours[t]), true);
    } else {
      if (number_of[number] == kNotYet) number_of[number] = list.Add(material);
      number = number_of[number];
    }
  }
  mesh.materials = list.Materials();
}

}  // namespace pleinair

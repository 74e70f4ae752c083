#include "scene/internal/cut_outs.h"

#include <algorithm>

#include "scene/textured_material.h"

namespace pleinair {

CutOuts::CutOuts(const Mesh& mesh) {
  const std::size_t count = std::min(mesh.triangle_colours.size(), mesh.triangle_material.size());
  for (std::size_t t = 0; t < count; ++t) {
    const Material& material = mesh.materials[mesh.triangle_material[t]];
    if (!material.by_place || !(material.by_place->alpha_cutoff > 0.0f)) continue;
    if (number_of_triangle_.empty()) number_of_triangle_.assign(mesh.triangles.size(), kWhole);
    number_of_triangle_[t] = static_cast<std::uint32_t>(cut_.size());
    cut_.push_back({material.by_place, mesh.triangle_colours[t]});
  }
}

bool CutOuts::IsThere(std::uint32_t triangle, float weight_1, float weight_2) const {
  const std::uint32_t number = number_of_triangle_[triangle];
  if (number == kWhole) return true;
  const Cut& cut = cut_[number];
  const auto& [uv_0, uv_1, uv_2] = cut.colours.texture_uv;
  const auto& [colour_0, colour_1, colour_2] = cut.colours.vertex_colour;
  const float weight_0 = 1.0f - weight_1 - weight_2;
  const glm::vec2 uv = weight_0 * uv_0 + weight_1 * uv_1 + weight_2 * uv_2;
  const glm::vec4 colour = weight_0 * colour_0 + weight_1 * colour_1 + weight_2 * colour_2;
  const TexturedMaterial& material = *cut.material;
  return material.base_alpha * material.ColourAt(uv, 0.0f, colour).a >= material.alpha_cutoff;
}

}  // namespace pleinair

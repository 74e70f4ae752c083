#include "scene/internal/textured_material.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace pleinair {
namespace {

constexpr float kMaxAlbedo = 0.98f;
// Steps of two codes are as fine as a display shows them.
constexpr float kColourSteps = 127.0f;
constexpr std::uint32_t kExactly = 0xffffffffu;

// sRGB without its straight foot: only the spacing of the steps hangs on it.
constexpr float kGamma = 2.2f;

}  // namespace

Material TexturedMaterial::WithColour(const glm::vec3& colour) const {
  const glm::vec3 here = base_colour * colour;
  Material material;
  material.name = name;
  material.diffuse_albedo =
      glm::clamp((1.0f - metallic) * here, glm::vec3(0.0f), glm::vec3(kMaxAlbedo));
  material.specular_reflectance = glm::clamp(
      glm::mix(dielectric_reflectance, here, metallic), glm::vec3(0.0f), glm::vec3(1.0f));
  material.roughness = roughness;
  return material;
}

bool TexturedMaterial::ExceedsLimits() const {
  const Material limited = Mean();
  const glm::vec3 mean = base_colour * (texture ? texture->Mean() : glm::vec3(1.0f));
  return limited.diffuse_albedo != (1.0f - metallic) * mean ||
         limited.specular_reflectance != glm::mix(dielectric_reflectance, mean, metallic);
}

std::uint32_t MaterialList::Index(std::uint32_t source, const glm::vec3& colour) {
  const TexturedMaterial& material = sources_[source];
  const glm::vec3 mean = material.texture ? material.texture->Mean() : glm::vec3(1.0f);
  std::uint32_t step = kExactly;
  glm::vec3 shown = colour;
  if (colour != mean) {
    step = 0;
    for (int c = 0; c < 3; ++c) {
      const float code = std::pow(std::clamp(colour[c], 0.0f, 1.0f), 1.0f / kGamma);
      const float nearest = std::round(kColourSteps * code);
      step = step << 8 | static_cast<std::uint32_t>(nearest);
      shown[c] = std::pow(nearest / kColourSteps, kGamma);
    }
  }
  const auto next = static_cast<std::uint32_t>(materials_.size());
  const auto [entry, is_new] = index_of_.try_emplace({source, step}, next);
  if (is_new) materials_.push_back(material.WithColour(shown));
  return entry->second;
}

}  // namespace pleinair

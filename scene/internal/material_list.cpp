#include "scene/internal/material_list.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace pleinair {
namespace {

// Steps of two codes are as fine as a display shows them.
constexpr float kColourSteps = 127.0f;
constexpr std::uint32_t kExactly = 0xffffffffu;

// sRGB without its straight foot: only the spacing of the steps depends on it.
constexpr float kGamma = 2.2f;

}  // namespace

std::uint32_t MaterialList::Add(Material material) {
  materials_.push_back(std::move(material));
  return static_cast<std::uint32_t>(materials_.size() - 1);
}

std::uint32_t MaterialList::Index(const std::shared_ptr<const TexturedMaterial>& source,
                                  const glm::vec3& colour,
                                  bool by_place) {
  const glm::vec3 mean = source->texture ? source->texture->Mean() : glm::vec3(1.0f);
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
  const auto [entry, is_new] = index_of_.try_emplace({source.get(), step, by_place}, next);
  if (is_new) {
    materials_.push_back(source->WithColour(shown));
    if (by_place) materials_.back().by_place = source;
  }
  return entry->second;
}

}  // namespace pleinair

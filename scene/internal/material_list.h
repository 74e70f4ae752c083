// Builds a mesh's list of materials: one for each requested colour.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/textured_material.h"

namespace pleinair {

class MaterialList {
 public:
  // Adds it unchanged.
  std::uint32_t Add(Material material);
  // The index of `source` with that colour, by place if asked. Colours are rounded to one of 128
  // steps of display code; white, and the mean of a texture, are exact.
  std::uint32_t Index(const std::shared_ptr<const TexturedMaterial>& source,
                      const glm::vec3& colour,
                      bool by_place);

  const std::vector<Material>& Materials() const { return materials_; }

 private:
  using Key = std::tuple<const TexturedMaterial*, std::uint32_t, bool>;

  std::vector<Material> materials_;
  std::map<Key, std::uint32_t> index_of_;
};

}  // namespace pleinair

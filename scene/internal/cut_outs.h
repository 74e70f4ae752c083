// Where triangles are cut out by the alpha of their textures.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "scene/mesh.h"

namespace pleinair {

// Holds no reference to the mesh. Safe from any thread.
class CutOuts {
 public:
  // Triangles without a material or colours have no cut-outs.
  explicit CutOuts(const Mesh& mesh);

  bool Empty() const { return cut_.empty(); }
  // Whether something is at a place, given by the weights of corners 1 and 2; the texture's finest
  // level decides.
  bool IsThere(std::uint32_t triangle, float weight_1, float weight_2) const;

 private:
  static constexpr std::uint32_t kWhole = 0xffffffffu;
  struct Cut {
    std::shared_ptr<const TexturedMaterial> material;
    TriangleColours colours;
  };

  std::vector<std::uint32_t> number_of_triangle_;  // Into cut_, or kWhole.
  std::vector<Cut> cut_;
};

}  // namespace pleinair

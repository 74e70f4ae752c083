// The same surface with more triangles.
#pragma once

#include <cstddef>
#include <cstdint>

#include <glm/geometric.hpp>

#include "scene/mesh.h"

namespace pleinair {

// Each triangle becomes four.
inline Mesh CutInFour(const Mesh& mesh) {
  Mesh cut = mesh;
  cut.triangles.clear();
  cut.triangle_material.clear();
  cut.triangle_group.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    const auto first = static_cast<std::uint32_t>(cut.positions_m.size());
    for (int edge = 0; edge < 3; ++edge) {
      const std::uint32_t a = v[edge];
      const std::uint32_t b = v[(edge + 1) % 3];
      cut.positions_m.push_back(0.5f * (mesh.positions_m[a] + mesh.positions_m[b]));
      cut.normals.push_back(glm::normalize(mesh.normals[a] + mesh.normals[b]));
    }
    cut.triangles.insert(cut.triangles.end(),
                         {{v.x, first, first + 2},
                          {first, v.y, first + 1},
                          {first + 2, first + 1, v.z},
                          {first, first + 1, first + 2}});
    for (int part = 0; part < 4; ++part) {
      cut.triangle_material.push_back(mesh.triangle_material[t]);
      cut.triangle_group.push_back(mesh.triangle_group[t]);
    }
  }
  return cut;
}

}  // namespace pleinair

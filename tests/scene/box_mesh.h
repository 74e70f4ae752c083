// Boxes for tests: closed, wound counter-clockwise from outside.
#pragma once

#include <array>
#include <cstdint>

#include <glm/vec3.hpp>

#include "scene/mesh.h"

namespace pleinair {

// Twelve triangles, vertices shared; normals are not those of the faces.
inline Mesh BoxMesh(const glm::vec3& lower_m, const glm::vec3& upper_m) {
  Mesh mesh;
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    mesh.positions_m.push_back({(corner & 1u) != 0 ? upper_m.x : lower_m.x,
                                (corner & 2u) != 0 ? upper_m.y : lower_m.y,
                                (corner & 4u) != 0 ? upper_m.z : lower_m.z});
    mesh.normals.push_back({0.0f, 0.0f, 1.0f});
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& face : kFaces) {
    mesh.triangles.push_back({face[0], face[1], face[2]});
    mesh.triangles.push_back({face[0], face[2], face[3]});
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.triangle_group.assign(mesh.triangles.size(), 0);
  mesh.materials.resize(1);
  mesh.group_names = {"box"};
  return mesh;
}

}  // namespace pleinair

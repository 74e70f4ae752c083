// Makes a clean indexed mesh from loose triangles, as files hold them.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/mesh_io.h"

namespace pleinair {

struct LooseCorner {
  glm::dvec3 position_m{0.0};
  glm::vec3 normal{0.0f};  // Zero or not finite: missing. Any length.
};

struct LooseTriangle {
  std::array<LooseCorner, 3> corners;
  TriangleColours colours;
  bool has_texture_uv = false;  // Else that of `colours` means nothing.
  bool is_by_place = false;     // Whether its material is looked up in `colours`.
  std::uint32_t material = 0;
  std::uint32_t group = 0;
};

// Fills the geometry of `mesh` (all but materials and group_names) and the counts of `report`. It
// leaves out triangles that are not finite, without area or duplicates, computes missing normals,
// and welds corners of equal position and normal. Order is kept. Colours are filled in where any
// triangle is by place.
void RepairTriangles(std::span<const LooseTriangle> loose, Mesh& mesh, MeshReport& report);

}  // namespace pleinair

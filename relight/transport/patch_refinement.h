// Cuts a mesh's triangles until no edge is too long, keeping neighbours joined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"

namespace pleinair {

struct RefinedMesh {
  Mesh mesh;
  std::vector<std::uint32_t> source_triangle;  // Per triangle of `mesh`.
};

// Longest edge allowed where an edge has its midpoint, in metres, > 0.
using TargetLength = std::function<double(const glm::vec3& midpoint_m)>;

// Splits every edge that is longer than its target at its midpoint, and each triangle into 2, 3 or
// 4 by its split edges, until none is left that can be split. An edge of a few units in the last
// place cannot: its middle is one of its ends. Whether and where an edge is split depends on its
// two end points alone, so two triangles that share an edge stay joined, also where the mesh stores
// that edge twice. Triangles without area are left out. What triangles are looked up in by place is
// cut along.
//
// Throws std::invalid_argument when more than `max_triangles` would come out.
RefinedMesh RefineMesh(const Mesh& mesh, const TargetLength& target, std::size_t max_triangles);
// The same; nothing when more would come out.
std::optional<RefinedMesh> TryRefineMesh(const Mesh& mesh,
                                         const TargetLength& target,
                                         std::size_t max_triangles);

}  // namespace pleinair

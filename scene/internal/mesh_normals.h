// Shading normals for meshes that come without.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair {

// Surfaces that meet at a flatter angle are shaded as one.
inline constexpr double kCreaseAngleRad = 1.0471975511965976;  // 60 deg: a box keeps its edges.

// A unit normal for each corner of each triangle. It is the mean of the triangles around that
// corner, weighted by their angle there, whose own normal is within kCreaseAngleRad of this one's.
// Triangles must have area and share corners by index where they share positions.
std::vector<std::array<glm::vec3, 3>> CornerNormals(std::span<const glm::vec3> positions,
                                                    std::span<const glm::uvec3> triangles);

}  // namespace pleinair

// The point of a simplex that is nearest to the origin.
#pragma once

#include <array>
#include <span>

#include <glm/vec3.hpp>

namespace pleinair {

struct NearestOfSimplex {
  glm::dvec3 point{0.0};
  unsigned corners = 0;  // The smallest face that holds it: bit i stands for corner i.
};

// Shape  1 to 4 corners; a degenerate simplex is the union of its faces.
NearestOfSimplex NearestToOrigin(std::span<const glm::dvec3> corners);

}  // namespace pleinair

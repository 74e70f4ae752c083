// Whether two surface points lie on one plane, as far as blending light between them goes.
#pragma once

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// Normals are within 5 deg, and either point is off the other's plane by less than 0.5 % of the
// viewing distance. That is well above a hit's rounding error (1e-6) and the bend of a finely
// faceted curve between neighbouring pixels, and well below any step that casts light of its own.
inline bool SamePlane(const glm::vec3& position_a,
                      const glm::vec3& normal_a,
                      const glm::vec3& position_b,
                      const glm::vec3& normal_b,
                      float range_m) {
  constexpr float kCosSameNormal = 0.9962f;
  constexpr float kOffPlanePerRange = 0.005f;
  if (!(glm::dot(normal_a, normal_b) > kCosSameNormal)) return false;
  const glm::vec3 apart = position_b - position_a;
  const float bound = kOffPlanePerRange * range_m;
  return std::abs(glm::dot(normal_a, apart)) < bound && std::abs(glm::dot(normal_b, apart)) < bound;
}

}  // namespace pleinair

// The angle between two directions.
#pragma once

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// 0 to pi, well conditioned for small angles too; lengths do not matter. 0 where one is zero.
inline double AngleBetweenRad(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace pleinair

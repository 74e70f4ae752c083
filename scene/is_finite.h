// Whether all of a vector is finite.
#pragma once

#include <cmath>

#include <glm/vec3.hpp>

namespace pleinair {

inline bool IsFinite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline bool IsFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace pleinair

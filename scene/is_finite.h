// Whether all of a vector is a number.
#pragma once

#include <cmath>

#include <glm/vec3.hpp>

namespace pleinair {

inline bool IsFinite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace pleinair

// The median of three channels: it stands against one that is dead or coloured.
#pragma once

#include <algorithm>

#include <glm/vec3.hpp>

namespace pleinair {

inline float Median(const glm::vec3& v) {
  return std::max(std::min(v.x, v.y), std::min(std::max(v.x, v.y), v.z));
}

}  // namespace pleinair

// Whether a value of a linear picture is a measurement.
#pragma once

#include <limits>

#include <glm/vec3.hpp>

namespace pleinair::estimation_internal {

// Finite and not below 0, in every channel.
inline bool IsMeasured(const glm::vec3& radiance) {
  // False for NaN, too.
  constexpr float kLargest = std::numeric_limits<float>::max();
  return radiance.x >= 0.0f && radiance.x <= kLargest && radiance.y >= 0.0f &&
         radiance.y <= kLargest && radiance.z >= 0.0f && radiance.z <= kLargest;
}

}  // namespace pleinair::estimation_internal

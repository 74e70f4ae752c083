// Which camera pixels hold a radiance.
#pragma once

#include <glm/vec3.hpp>

namespace pleinair {

inline bool IsKnownRadiance(const glm::vec3& camera) {
  return camera.x >= 0.0f && camera.y >= 0.0f && camera.z >= 0.0f && camera.x < 1e37f &&
         camera.y < 1e37f && camera.z < 1e37f;
}

}  // namespace pleinair

// Where a camera is.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// In the frame that a rigid pose starts from.
inline glm::dvec3 CentreOfCamera(const glm::dmat4& camera_from_world) {
  return -(glm::transpose(glm::dmat3(camera_from_world)) * glm::dvec3(camera_from_world[3]));
}

}  // namespace pleinair

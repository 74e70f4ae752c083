// Checks of a compositor's input.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "render/compositor.h"
#include "scene/camera.h"

namespace pleinair {

// All throw std::invalid_argument naming what is wrong, and what was expected.
void ValidateCamera(const Camera& camera);
void ValidateInput(const CompositeInput& input, std::span<const VirtualObject> objects);
// `direction`, of length 1 to a thousandth, normalised.
glm::dvec3 ValidatedDirection(const glm::dvec3& direction);

}  // namespace pleinair

// Where the sun stands.
#pragma once

#include <glm/vec3.hpp>

#include "scene/lighting.h"

namespace pleinair {

// Its direction, apparent (refracted), and how large it is.
struct SunState {
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};
  double angular_radius_rad = kMeanSunAngularRadiusRad;
};

}  // namespace pleinair

// Directions in words.
#pragma once

#include <string>

#include <glm/vec3.hpp>

namespace pleinair {

// "azimuth 144.0 deg, elevation 52.6 deg", for people.
std::string AzimuthAndElevation(const glm::dvec3& direction_enu);

}  // namespace pleinair

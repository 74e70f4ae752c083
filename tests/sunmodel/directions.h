// Directions as tables give them, and the angle between two.
#pragma once

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "sunmodel/angles.h"

namespace pleinair {

inline glm::dvec3 DirectionFromDegrees(double azimuth_deg, double elevation_deg) {
  const double azimuth = RadFromDeg(azimuth_deg);
  const double elevation = RadFromDeg(elevation_deg);
  return {std::sin(azimuth) * std::cos(elevation),
          std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

inline double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return DegFromRad(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

}  // namespace pleinair

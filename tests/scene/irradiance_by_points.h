// A second way to a sky shape's integral.
#pragma once

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "scene/sky_shape.h"

namespace pleinair::testing {

// Irradiance on a horizontal plane by points of equal projected area.
inline glm::dvec3 IrradianceByPoints(const SkyShape& shape, int points) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < points; ++i) {
    const double radius = std::sqrt((i + 0.5) / points);
    const double azimuth = 2.0 * std::numbers::pi * i * (std::numbers::phi - 1.0);
    sum += glm::dvec3(shape.Radiance(glm::normalize(glm::vec3(radius * std::cos(azimuth),
                                                              radius * std::sin(azimuth),
                                                              std::sqrt(1.0 - radius * radius)))));
  }
  return std::numbers::pi / points * sum;
}

}  // namespace pleinair::testing

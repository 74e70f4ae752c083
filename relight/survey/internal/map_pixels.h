// Pixels of a lat-long map around a direction.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "scene/lat_long.h"

namespace pleinair {

struct MapPixel {
  int x = 0;
  int y = 0;
  double angle_rad = 0.0;  // From the direction.
};

inline glm::dvec3 MapPixelDirection(int x, int y, LatLongSize size) {
  return DirectionFromLatLong({x + 0.5, y + 0.5}, size);
}

// The pixels within `radius_rad` of a unit direction, in row-major order.
std::vector<MapPixel> MapPixelsAround(const glm::dvec3& direction,
                                      double radius_rad,
                                      LatLongSize size);

}  // namespace pleinair

#include "relight/survey/internal/map_pixels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/angle_between.h"

namespace pleinair {

std::vector<MapPixel> MapPixelsAround(const glm::dvec3& direction,
                                      double radius_rad,
                                      LatLongSize size) {
  std::vector<MapPixel> pixels;
  const double v = LatLongFromDirection(direction, size).y;
  const double reach = radius_rad / std::numbers::pi * size.height + 1.0;
  const int first = std::max(0, static_cast<int>(std::floor(v - reach)));
  const int last = std::min(size.height - 1, static_cast<int>(std::ceil(v + reach)));
  for (int y = first; y <= last; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const glm::dvec3 there = MapPixelDirection(x, y, size);
      const double angle = AngleBetweenRad(direction, there);
      if (angle <= radius_rad) pixels.push_back({x, y, angle});
    }
  }
  return pixels;
}

}  // namespace pleinair

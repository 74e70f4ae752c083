// A lat-long map's pixels as rays.
#pragma once

#include "relight/transport/surface_gather.h"
#include "scene/lat_long.h"

namespace pleinair {

inline ViewRays MapRays(LatLongSize size, const glm::vec3& position_m) {
  return {.width = size.width,
          .height = size.height,
          .wraps_x = true,
          .origin_m = position_m,
          .direction = [size](int x, int y) {
            return glm::vec3(DirectionFromLatLong({x + 0.5, y + 0.5}, size));
          }};
}

}  // namespace pleinair

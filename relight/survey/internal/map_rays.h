// A lat-long map's pixels as rays.
#pragma once

#include <memory>

#include "relight/transport/view_rays.h"
#include "scene/lat_long.h"

namespace pleinair {

inline ViewRays MapRays(LatLongSize size, const glm::vec3& position_m) {
  auto directions = std::make_shared<Image<glm::vec3>>(size.width, size.height);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      directions->At(x, y) = glm::vec3(DirectionFromLatLong({x + 0.5, y + 0.5}, size));
    }
  }
  return {.width = size.width,
          .height = size.height,
          .wraps_x = true,
          .origin_m = position_m,
          .directions = std::move(directions)};
}

}  // namespace pleinair

// A view as rays.
#pragma once

#include <cstddef>
#include <memory>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// Pixels of a view as rays from one point.
struct ViewRays {
  int width = 0;
  int height = 0;
  bool wraps_x = false;  // The first and last column are neighbours (lat-long maps).
  glm::vec3 origin_m{0.0f};
  glm::mat3 world_from_view{1.0f};
  // In the view's frame, unit, through the pixels' centres; zero where no light comes from.
  std::shared_ptr<const Image<glm::vec3>> directions;

  // In the world.
  glm::vec3 Direction(std::size_t pixel) const {
    return world_from_view * directions->pixels[pixel];
  }
};

}  // namespace pleinair

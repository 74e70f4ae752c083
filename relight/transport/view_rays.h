// A view as rays.
#pragma once

#include <functional>
#include <optional>

#include <glm/vec3.hpp>

namespace pleinair {

// Pixels of a view as rays from one point.
struct ViewRays {
  int width = 0;
  int height = 0;
  bool wraps_x = false;  // The first and last column are neighbours (lat-long maps).
  glm::vec3 origin_m{0.0f};
  // Unit direction through a pixel's centre; none where no light comes from.
  std::function<std::optional<glm::vec3>(int x, int y)> direction;
};

}  // namespace pleinair

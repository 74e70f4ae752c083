// The outline of a wall in its plane.
#pragma once

#include <span>
#include <vector>

#include <glm/vec2.hpp>

namespace pleinair {

// A part of the plane: along the wall and up, metres.
struct WallRectangle {
  glm::dvec2 lower{0.0};
  glm::dvec2 upper{0.0};
};

// `bounds` in rectangles, without what is open.
//
// `on_wall`   points of the wall; `seen_through` where lines of sight to points behind it pass.
// `cell_m`    size of the squares of which each is wall or open; those without either are as the
//             nearest one that has.
std::vector<WallRectangle> OutlineWall(const WallRectangle& bounds,
                                       std::span<const glm::dvec2> on_wall,
                                       std::span<const glm::dvec2> seen_through,
                                       double cell_m);

}  // namespace pleinair

// The spread of points in space: along a line, in a plane, or in all directions.
#pragma once

#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// Points whose spread across a line is this share of that along it are on the line: less than what
// single-precision coordinates hold.
inline constexpr double kOnALine = 1e-6;

struct PointSpread {
  glm::dvec3 centre{0.0};
  // Extents of the points about their centre, largest first: root of the sum of squares by axis.
  glm::dvec3 singular_values{0.0};
  glm::dmat3 axes_from_world{1.0};  // A rotation; rows are the axes, in the same order.

  bool IsALine() const { return !(singular_values.y > kOnALine * singular_values.x); }
};

// The spread of at least one point.
PointSpread SpreadOf(std::span<const glm::dvec3> points);

}  // namespace pleinair

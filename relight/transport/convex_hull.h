// The convex hull of points in a plane.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

namespace pleinair {

// Twice the signed area of the triangle o, a, b: above 0 where it turns left.
inline double TurnOf(const glm::dvec2& o, const glm::dvec2& a, const glm::dvec2& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

// Counter-clockwise, of these points. OpenCV compares them as float: of points in metres near the
// origin none is outside by more than 1e-6 m.
std::vector<glm::dvec2> ConvexHull(const std::vector<glm::dvec2>& points);

}  // namespace pleinair

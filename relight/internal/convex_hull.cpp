#include "relight/internal/convex_hull.h"

#include <algorithm>

namespace pleinair {

std::vector<glm::dvec2> ConvexHull(std::vector<glm::dvec2> points) {
  std::sort(points.begin(), points.end(), [](const glm::dvec2& p, const glm::dvec2& q) {
    return p.x != q.x ? p.x < q.x : p.y < q.y;
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  std::vector<glm::dvec2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = hull.size();
    for (const glm::dvec2& point : points) {
      while (hull.size() >= first + 2 && TurnOf(hull[hull.size() - 2], hull.back(), point) <= 0.0) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    if (!hull.empty()) hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

}  // namespace pleinair

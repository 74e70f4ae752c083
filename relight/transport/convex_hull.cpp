#include "relight/transport/convex_hull.h"

#include <opencv2/imgproc.hpp>

namespace pleinair {

std::vector<glm::dvec2> ConvexHull(const std::vector<glm::dvec2>& points) {
  std::vector<cv::Point2f> rounded;
  rounded.reserve(points.size());
  for (const glm::vec2 point : points) rounded.emplace_back(point.x, point.y);
  std::vector<int> corners;
  if (!points.empty()) cv::convexHull(rounded, corners);
  std::vector<glm::dvec2> hull;
  hull.reserve(corners.size());
  for (const int corner : corners) hull.push_back(points[static_cast<std::size_t>(corner)]);
  return hull;
}

}  // namespace pleinair

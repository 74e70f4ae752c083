#include "calib/internal/point_spread.h"

#include <algorithm>

#include <glm/matrix.hpp>
#include <opencv2/core.hpp>

namespace pleinair {

PointSpread SpreadOf(std::span<const glm::dvec3> points) {
  PointSpread spread;
  for (const glm::dvec3& point : points) spread.centre += point;
  spread.centre /= static_cast<double>(points.size());
  // Never fewer rows than axes: three axes are wanted of two points, too.
  cv::Mat offsets = cv::Mat::zeros(std::max(3, static_cast<int>(points.size())), 3, CV_64F);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      offsets.at<double>(static_cast<int>(i), c) = points[i][c] - spread.centre[c];
    }
  }
  const cv::SVD svd(offsets);
  for (int axis = 0; axis < 3; ++axis) {
    spread.singular_values[axis] = svd.w.at<double>(axis);
    for (int c = 0; c < 3; ++c) spread.axes_from_world[c][axis] = svd.vt.at<double>(axis, c);
  }
  if (glm::determinant(spread.axes_from_world) < 0.0) {
    for (int c = 0; c < 3; ++c) spread.axes_from_world[c][2] *= -1.0;
  }
  return spread;
}

}  // namespace pleinair

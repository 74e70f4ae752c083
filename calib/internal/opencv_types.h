// OpenCV's types from ours, and back.
#pragma once

#include <cstdint>

#include <glm/mat4x4.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "scene/image.h"

namespace pleinair {

// OpenCV's view of our pixels, not a copy: for writing only where the picture itself is not const.
inline cv::Mat MatOf(const Gray8Image& picture) {
  return {picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.pixels.data())};
}

// From a rotation vector and a translation, as OpenCV's solvers return them.
inline glm::dmat4 PoseFrom(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  cv::Matx33d rotation;
  cv::Rodrigues(rotation_vector, rotation);
  glm::dmat4 pose(1.0);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) pose[column][row] = rotation(row, column);
    pose[3][column] = translation.at<double>(column);
  }
  return pose;
}

}  // namespace pleinair

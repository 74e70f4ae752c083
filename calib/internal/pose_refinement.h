// Least squares over a camera's six degrees of freedom.
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>
#include <glm/mat4x4.hpp>

#include "calib/camera_pose.h"
#include "calib/fisheye_lens.h"
#include "scene/camera.h"

namespace pleinair {

struct RefinedPose {
  glm::dmat4 camera_from_world{1.0};
  double sum_squares_px = 0.0;
  // Sum of J^T J at the solution; J is d pixel / d (rotation, translation) of a camera-frame point
  // x that moves to exp(rotation) x + translation.
  Eigen::Matrix<double, 6, 6> normal;
};

// Levenberg-Marquardt (Ceres' TinySolver) over all matches from `start`; none where a point is not
// before the camera.
std::optional<RefinedPose> RefinePose(const CameraIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& start);
// The same of a fish-eye lens of OpenCV's model, all around it.
std::optional<RefinedPose> RefinePose(const FisheyeIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& start);

}  // namespace pleinair

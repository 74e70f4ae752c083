// Least squares over a camera's six degrees of freedom.
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>
#include <glm/mat4x4.hpp>

#include "calib/camera_pose.h"
#include "scene/camera.h"

namespace pleinair {

// d pixel / d (rotation, translation) of a camera-frame point x that moves to exp(rotation) x +
// translation, at none. Rows u, v.
using PoseJacobian = Eigen::Matrix<double, 2, 6>;

// exp(step.head<3>()) pose + step.tail<3>().
glm::dmat4 MovedPose(const glm::dmat4& pose, const Eigen::Matrix<double, 6, 1>& step);

// Projects camera-frame points by OpenCV's model, with the derivatives.
void ProjectWithJacobian(const CameraIntrinsics& intrinsics,
                         std::span<const glm::dvec3> points_camera,
                         std::vector<glm::dvec2>& pixels,
                         std::vector<PoseJacobian>& jacobians);

struct RefinedPose {
  glm::dmat4 camera_from_world{1.0};
  double sum_squares_px = 0.0;
  Eigen::Matrix<double, 6, 6> normal;  // Sum of J^T J at the solution.
};

// Levenberg-Marquardt over all matches from `start`; none where a point is not before the camera.
std::optional<RefinedPose> RefinePose(const CameraIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& start);

}  // namespace pleinair

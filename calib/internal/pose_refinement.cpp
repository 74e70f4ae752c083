#include "calib/internal/pose_refinement.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>

namespace pleinair {
namespace {

struct Linearised {
  double sum_squares = 0.0;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
};

std::optional<Linearised> Linearise(const CameraIntrinsics& intrinsics,
                                    std::span<const PointMatch> matches,
                                    const glm::dmat4& pose) {
  std::vector<glm::dvec3> points;
  for (const PointMatch& match : matches) {
    points.emplace_back(pose * glm::dvec4(match.point_world_m, 1.0));
    if (!(points.back().z > 0.0)) return std::nullopt;
  }
  std::vector<glm::dvec2> pixels;
  std::vector<PoseJacobian> jacobians;
  ProjectWithJacobian(intrinsics, points, pixels, jacobians);
  Linearised result;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const glm::dvec2 off = pixels[i] - matches[i].pixel;
    const Eigen::Vector2d residual(off.x, off.y);
    result.sum_squares += residual.squaredNorm();
    result.normal += jacobians[i].transpose() * jacobians[i];
    result.gradient += jacobians[i].transpose() * residual;
  }
  if (!std::isfinite(result.sum_squares)) return std::nullopt;
  return result;
}

}  // namespace

glm::dmat4 MovedPose(const glm::dmat4& pose, const Eigen::Matrix<double, 6, 1>& step) {
  const Eigen::Vector3d turn = step.head<3>();
  const double angle = turn.norm();
  const Eigen::Vector3d axis =
      angle > 0.0 ? Eigen::Vector3d(turn / angle) : Eigen::Vector3d::UnitX();
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  glm::dmat4 motion(1.0);
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) motion[column][row] = rotation(row, column);
  }
  motion[3] = glm::dvec4(step[3], step[4], step[5], 1.0);
  return motion * pose;
}

void ProjectWithJacobian(const CameraIntrinsics& intrinsics,
                         std::span<const glm::dvec3> points_camera,
                         std::vector<glm::dvec2>& pixels,
                         std::vector<PoseJacobian>& jacobians) {
  const cv::Matx33d camera(intrinsics.fx_px,
                           0.0,
                           intrinsics.cx_px,
                           0.0,
                           intrinsics.fy_px,
                           intrinsics.cy_px,
                           0.0,
                           0.0,
                           1.0);
  std::vector<cv::Point3d> points;
  for (const glm::dvec3& point : points_camera) points.emplace_back(point.x, point.y, point.z);
  std::vector<cv::Point2d> projected;
  cv::Mat derivatives;
  const std::vector<double> distortion(intrinsics.distortion.begin(), intrinsics.distortion.end());
  // At no rotation, OpenCV's derivative by the rotation vector is that by a small turn.
  cv::projectPoints(
      points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), camera, distortion, projected, derivatives);
  pixels.clear();
  jacobians.clear();
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    pixels.emplace_back(projected[static_cast<std::size_t>(i)].x,
                        projected[static_cast<std::size_t>(i)].y);
    PoseJacobian& jacobian = jacobians.emplace_back();
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 6; ++column) {
        jacobian(row, column) = derivatives.at<double>(2 * i + row, column);
      }
    }
  }
}

std::optional<RefinedPose> RefinePose(const CameraIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& start) {
  constexpr int kMostSteps = 50;
  // The descent is quadratic at its end: what follows a smaller relative gain is rounding.
  constexpr double kLeastGain = 1e-10;
  glm::dmat4 pose = start;
  auto now = Linearise(intrinsics, matches, pose);
  if (!now) return std::nullopt;
  double damping = 1e-4;
  for (int i = 0; i < kMostSteps && damping < 1e12; ++i) {
    Eigen::Matrix<double, 6, 6> damped = now->normal;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::Matrix<double, 6, 1> step = damped.ldlt().solve(-now->gradient);
    if (!step.allFinite()) break;
    const glm::dmat4 moved = MovedPose(pose, step);
    const auto next = Linearise(intrinsics, matches, moved);
    if (!next || !(next->sum_squares < now->sum_squares)) {
      damping *= 10.0;
      continue;
    }
    const bool done = now->sum_squares - next->sum_squares <= kLeastGain * now->sum_squares;
    pose = moved;
    now = next;
    damping = std::max(1e-12, 0.1 * damping);
    if (done) break;
  }
  return RefinedPose{pose, now->sum_squares, now->normal};
}

}  // namespace pleinair

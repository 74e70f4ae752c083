#include "calib/internal/pose_refinement.h"

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>

#include "calib/internal/reprojection.h"

namespace pleinair {
namespace {

// Errors of all matches and their derivatives by the camera's motion from `pose`.
struct PixelErrors {
  int NumResiduals() const { return 2 * static_cast<int>(matches.size()); }

  // Flattened: as CornerError's.
  template <typename T>
  [[gnu::flatten]] bool operator()(const T* motion, T* errors) const {
    for (const PointMatch& match : matches) {
      const glm::dvec4 point = pose * glm::dvec4(match.point_world_m, 1.0);
      const auto moved = MovedPoint<T>(motion, {T(point.x), T(point.y), T(point.z)});
      if (!PixelError(intrinsics, moved, match.pixel, errors)) return false;
      errors += 2;
    }
    return true;
  }

  const CameraIntrinsics& intrinsics;
  std::span<const PointMatch> matches;
  glm::dmat4 pose;
};

using PixelErrorsAndJacobian = ceres::TinySolverAutoDiffFunction<PixelErrors, Eigen::Dynamic, 6>;

// Without motion.
std::optional<RefinedPose> Linearised(const CameraIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& pose) {
  const PixelErrors errors{intrinsics, matches, pose};
  Eigen::VectorXd residuals(errors.NumResiduals());
  Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian(errors.NumResiduals(), 6);
  const Motion none = Motion::Zero();
  if (!PixelErrorsAndJacobian(errors)(none.data(), residuals.data(), jacobian.data())) {
    return std::nullopt;
  }
  return RefinedPose{pose, residuals.squaredNorm(), jacobian.transpose() * jacobian};
}

}  // namespace

std::optional<RefinedPose> RefinePose(const CameraIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& start) {
  if (!Linearised(intrinsics, matches, start)) return std::nullopt;
  const PixelErrors errors{intrinsics, matches, start};
  ceres::TinySolver<PixelErrorsAndJacobian> solver;
  // The descent is quadratic at its end: what follows a smaller step is rounding. The other
  // tolerances are absolute, and square pixels have no scale to set them by.
  solver.options.parameter_tolerance = 1e-10;
  solver.options.function_tolerance = 0.0;
  solver.options.cost_threshold = 0.0;
  solver.options.gradient_tolerance = 0.0;
  Motion motion = Motion::Zero();
  solver.Solve(PixelErrorsAndJacobian(errors), &motion);
  return Linearised(intrinsics, matches, MovedPose(start, motion));
}

}  // namespace pleinair

#include "calib/internal/pose_refinement.h"

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>

#include "calib/internal/reprojection.h"

namespace pleinair {
namespace {

// Errors of all matches and their derivatives by the camera's motion from `pose`.
template <typename Intrinsics>
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

  const Intrinsics& intrinsics;
  std::span<const PointMatch> matches;
  glm::dmat4 pose;
};

template <typename Intrinsics>
using PixelErrorsAndJacobian =
    ceres::TinySolverAutoDiffFunction<PixelErrors<Intrinsics>, Eigen::Dynamic, 6>;

// Without motion.
template <typename Intrinsics>
std::optional<RefinedPose> Linearised(const Intrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& pose) {
  const PixelErrors<Intrinsics> errors{intrinsics, matches, pose};
  Eigen::VectorXd residuals(errors.NumResiduals());
  Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian(errors.NumResiduals(), 6);
  const Motion none = Motion::Zero();
  if (!PixelErrorsAndJacobian<Intrinsics>(errors)(none.data(), residuals.data(), jacobian.data())) {
    return std::nullopt;
  }
  return RefinedPose{pose, residuals.squaredNorm(), jacobian.transpose() * jacobian};
}

template <typename Intrinsics>
std::optional<RefinedPose> Refine(const Intrinsics& intrinsics,
                                  std::span<const PointMatch> matches,
                                  const glm::dmat4& start) {
  if (!Linearised(intrinsics, matches, start)) return std::nullopt;
  const PixelErrors<Intrinsics> errors{intrinsics, matches, start};
  ceres::TinySolver<PixelErrorsAndJacobian<Intrinsics>> solver;
  // The descent is quadratic at its end: what follows a smaller step is rounding. The other
  // tolerances are absolute, and square pixels have no scale to set them by.
  solver.options.parameter_tolerance = 1e-10;
  solver.options.function_tolerance = 0.0;
  solver.options.cost_threshold = 0.0;
  solver.options.gradient_tolerance = 0.0;
  Motion motion = Motion::Zero();
  solver.Solve(PixelErrorsAndJacobian<Intrinsics>(errors), &motion);
  return Linearised(intrinsics, matches, MovedPose(start, motion));
}

}  // namespace

std::optional<RefinedPose> RefinePose(const CameraIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& start) {
  return Refine(intrinsics, matches, start);
}

std::optional<RefinedPose> RefinePose(const FisheyeIntrinsics& intrinsics,
                                      std::span<const PointMatch> matches,
                                      const glm::dmat4& start) {
  return Refine(intrinsics, matches, start);
}

}  // namespace pleinair

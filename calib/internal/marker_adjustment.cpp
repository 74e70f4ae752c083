#include "calib/internal/marker_adjustment.h"

#include <limits>

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <glm/geometric.hpp>

#include "calib/internal/reprojection.h"

namespace pleinair {
namespace {

constexpr double kHuberPx = 1.0;

// Error of one corner and its derivatives by the motions of the camera and of the marker.
struct CornerError {
  // Flattened: in a unity build GCC's budget for inlining ends within the jets, which costs 1.5
  // times the time.
  template <typename T>
  [[gnu::flatten]] bool operator()(const T* camera_motion, const T* marker_motion, T* error) const {
    const std::array<T, 3> world =
        MovedPoint(marker_motion, {T(corner_world_m.x), T(corner_world_m.y), T(corner_world_m.z)});
    std::array<T, 3> camera;
    for (int row = 0; row < 3; ++row) {
      camera[static_cast<std::size_t>(row)] =
          world[0] * camera_from_world[0][row] + world[1] * camera_from_world[1][row] +
          world[2] * camera_from_world[2][row] + camera_from_world[3][row];
    }
    return PixelError(intrinsics, MovedPoint(camera_motion, camera), pixel, error);
  }

  const CameraIntrinsics& intrinsics;
  glm::dmat4 camera_from_world;
  glm::dvec3 corner_world_m;
  glm::dvec2 pixel;
};

}  // namespace

double SumSquaresPx(const Lens& lens,
                    const std::array<glm::dvec3, 4>& square,
                    const DetectedMarker& marker,
                    const glm::dmat4& camera_from_marker) {
  double sum = 0.0;
  for (std::size_t c = 0; c < 4; ++c) {
    const auto pixel =
        lens.ProjectToPixel(glm::dvec3(camera_from_marker * glm::dvec4(square[c], 1.0)));
    if (!pixel) return std::numeric_limits<double>::infinity();
    const glm::dvec2 off = *pixel - marker.corners_px[c];
    sum += glm::dot(off, off);
  }
  return sum;
}

void AdjustMarkerLayout(const SeenMarkers& seen,
                        int reference_id,
                        int steps,
                        MarkerLayout& layout) {
  const auto& [lens, square, views] = seen;
  std::map<glm::dmat4*, Motion> motions;
  const auto motion_of = [&](glm::dmat4& pose) {
    return motions.try_emplace(&pose, Motion::Zero()).first->second.data();
  };
  ceres::HuberLoss huber(kHuberPx);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (auto& [v, camera_from_world] : layout.camera_from_world) {
    for (const DetectedMarker& marker : views[v]->markers) {
      const auto placed = layout.world_from_marker.find(marker.id);
      if (placed == layout.world_from_marker.end()) continue;
      for (std::size_t c = 0; c < 4; ++c) {
        const glm::dvec3 corner(placed->second * glm::dvec4(square[c], 1.0));
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<CornerError, 2, 6, 6>(new CornerError{
                lens.Intrinsics(), camera_from_world, corner, marker.corners_px[c]}),
            &huber,
            motion_of(camera_from_world),
            motion_of(placed->second));
      }
    }
  }
  double* const reference = motion_of(layout.world_from_marker.at(reference_id));
  problem.AddParameterBlock(reference, 6);
  problem.SetParameterBlockConstant(reference);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = steps;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (const auto& [pose, motion] : motions) *pose = MovedPose(*pose, motion);
}

}  // namespace pleinair

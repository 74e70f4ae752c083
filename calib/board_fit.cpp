#include "calib/board_fit.h"

#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "calib/internal/board_matches.h"
#include "calib/internal/pose_refinement.h"
#include "calib/internal/pose_search.h"
#include "calib/internal/reprojection.h"

namespace pleinair {
namespace {

Lens SetUp(const CameraIntrinsics& lens) { return Lens(lens); }
FisheyeLens SetUp(const FisheyeIntrinsics& lens) { return FisheyeLens(lens); }

// Rows: right, down and ahead of a view along `axis`.
glm::dmat3 ViewAlong(const glm::dvec3& axis) {
  const glm::dvec3 other =
      std::abs(axis.x) < 0.5 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 right = glm::normalize(glm::cross(other, axis));
  return glm::transpose(glm::dmat3(right, glm::cross(axis, right), axis));
}

// Poses to begin with. A fish-eye sees boards that no plane before it holds: they are looked at
// along their own middle.
template <typename Intrinsics>
std::vector<glm::dmat4> FirstPoses(const Intrinsics& intrinsics,
                                   std::span<const PointMatch> matches) {
  const auto lens = SetUp(intrinsics);
  std::vector<glm::dvec3> points;
  std::vector<glm::dvec3> directions;
  glm::dvec3 sum(0.0);
  for (const PointMatch& match : matches) {
    const auto direction = lens.DirectionFromPixel(match.pixel);
    if (!direction) continue;
    points.push_back(match.point_world_m);
    directions.push_back(*direction);
    sum += *direction;
  }
  if (!(glm::length(sum) > 0.0)) return {};
  const glm::dmat3 view_from_camera = ViewAlong(glm::normalize(sum));
  std::vector<glm::dvec2> rays;
  for (const glm::dvec3& direction : directions) {
    const glm::dvec3 seen = view_from_camera * direction;
    if (!(seen.z > 0.0)) return {};
    rays.emplace_back(seen.x / seen.z, seen.y / seen.z);
  }
  std::vector<glm::dmat4> poses = FlatPoses(points, rays);
  for (glm::dmat4& pose : poses) pose = glm::dmat4(glm::transpose(view_from_camera)) * pose;
  return poses;
}

template <typename Intrinsics>
std::optional<BoardFit> Fit(const Intrinsics& lens, std::span<const PointMatch> matches) {
  std::optional<RefinedPose> best;
  for (const glm::dmat4& start : FirstPoses(lens, matches)) {
    const auto refined = RefinePose(lens, matches, start);
    if (refined && (!best || refined->sum_squares_px < best->sum_squares_px)) best = refined;
  }
  if (!best) return std::nullopt;
  BoardFit fit;
  for (const PointMatch& match : matches) {
    const glm::dvec4 at = best->camera_from_world * glm::dvec4(match.point_world_m, 1.0);
    std::array<double, 2> off{};
    PixelError(lens, std::array<double, 3>{at.x, at.y, at.z}, match.pixel, off.data());
    fit.residual_px.emplace_back(-off[0], -off[1]);
  }
  fit.rms_px = std::sqrt(best->sum_squares_px / static_cast<double>(matches.size()));
  return fit;
}

}  // namespace

std::optional<BoardFit> FitBoard(const AnyLens& lens, const BoardPicture& picture) {
  const std::vector<PointMatch> matches = MatchesOf(picture);
  return std::visit([&](const auto& model) { return Fit(model, matches); }, lens);
}

}  // namespace pleinair

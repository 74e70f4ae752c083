#include "calib/edge_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <ceres/tiny_solver.h>
#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/internal/check_number.h"
#include "calib/internal/edge_view.h"
#include "calib/internal/reprojection.h"
#include "calib/internal/residual_text.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr std::size_t kFewSamples = 160;  // While poses are tried.
// How near edges are where a pose is right; those of a wrong one are drawn near, and miss by more.
constexpr double kSharpPx = 0.7;
// A pose on whose edges the picture has this share of what the best one's have is as good.
constexpr double kRivalShare = 0.9;

UndeterminedPose OpenPose(const std::string& why, std::vector<PoseCandidate> candidates = {}) {
  return {"the camera's pose cannot be determined from edges: " + why, std::move(candidates)};
}

struct Stage {
  double reach_px;
  double scale_px;  // Scale of the weights.
  int rounds;
  double hold = 0.0;  // Root of the weight by which samples stay where the rough pose puts them.
  std::size_t samples = kFewSamples;
};

// The pose moved by rounds of matching and least squares; none where too little is in view.
std::optional<glm::dmat4> Moved(const EdgeView& view,
                                const PictureSlopes& slopes,
                                const Stage& stage,
                                const glm::dmat4& rough,
                                glm::dmat4 pose) {
  for (int round = 0; round < stage.rounds; ++round) {
    std::vector<EdgePlace> samples = view.PlacesOf(pose, slopes, stage.samples);
    for (EdgePlace& sample : samples) sample.steps_px = StepsAlong(slopes, sample, stage.reach_px);
    std::vector<EdgeMatch> matches = MatchesOf(samples, stage.scale_px);
    if (matches.size() < kFewestEdgePlaces / 2) return std::nullopt;
    for (const EdgePlace& sample : samples) {
      const auto before = view.Project(rough, sample.point_m);
      if (!(stage.hold > 0.0) || !before) continue;
      for (const glm::dvec2& axis : {glm::dvec2(1.0, 0.0), glm::dvec2(0.0, 1.0)}) {
        matches.push_back({sample.edge, {sample.point_m, *before}, axis, stage.hold});
      }
    }
    const NormalErrors errors{view.Intrinsics(), matches, pose};
    ceres::TinySolver<NormalErrorsAndJacobian> solver;
    solver.options.max_num_iterations = 2;  // One step: matches change anyway.
    Motion motion = Motion::Zero();
    solver.Solve(NormalErrorsAndJacobian(errors), &motion);
    if (!motion.allFinite()) return std::nullopt;
    pose = MovedPose(pose, motion);
    constexpr double kStands = 1e-5;  // Radians and metres: below 0.01 px.
    if (motion.norm() < kStands) break;
  }
  return pose;
}

// How much of the mesh's edges the picture has, each sample by how near.
double Support(const EdgeView& view, const PictureSlopes& slopes, const glm::dmat4& pose) {
  std::vector<EdgePlace> samples = view.PlacesOf(pose, slopes);
  if (samples.size() < kFewestEdgePlaces) return 0.0;
  double sum = 0.0;
  for (EdgePlace& sample : samples) {
    sample.steps_px = StepsAlong(slopes, sample, 2.0 * kNearPx);
    const double nearest = sample.NearestPx() / kSharpPx;
    if (std::isfinite(nearest)) sum += std::exp(-nearest * nearest);
  }
  return sum / static_cast<double>(samples.size());
}

glm::dmat4 Turned(const glm::dmat4& pose, double pan_rad, double tilt_rad) {
  Motion motion = Motion::Zero();
  motion[0] = tilt_rad;
  motion[1] = pan_rad;
  return MovedPose(pose, motion);
}

// The covariance of the camera's motion. The model: each group of edges is displaced along its
// normal by an amount of its own, mesh_sigma_m in the world, over its complete length; samples
// scatter about that. The distance of groups from the picture's edges, over what the model expects
// of a pose that is fitted to them, corrects mesh_sigma_m.
Eigen::Matrix<double, 6, 6> CovarianceOf(const EdgeView& view,
                                         const std::vector<EdgeMatch>& matches,
                                         const glm::dmat4& pose,
                                         double mesh_sigma_m) {
  const auto [residuals, jacobian] = Linearised(NormalErrors{view.Intrinsics(), matches, pose});
  const auto count = static_cast<int>(residuals.size());
  const Eigen::Matrix<double, 6, 6> inverse =
      (jacobian.transpose() * jacobian).fullPivLu().inverse();

  const std::vector<EdgeGroup> group_of = GroupsOf(matches);
  Eigen::Index groups = 0;
  for (const EdgeGroup& group : group_of) {
    groups = std::max(groups, static_cast<Eigen::Index>(group.number + 1));
  }
  // For each group: the change of the normal equations' right side when the group is displaced by
  // one deviation, and the group's mean residual in deviations.
  Eigen::Matrix<double, 6, Eigen::Dynamic> pulls(6, groups);
  Eigen::Matrix<double, Eigen::Dynamic, 6> means(groups, 6);
  Eigen::VectorXd mean_residual(groups);
  Eigen::VectorXd sizes(groups);
  Eigen::VectorXd offsets(count);
  pulls.setZero();
  means.setZero();
  mean_residual.setZero();
  sizes.setZero();
  // Of a group in the picture, whatever the mesh: blur, and the threshold between what it
  // separates. Its samples scatter about that, which `variance` below counts.
  constexpr double kGroupSigmaPx = 0.1;
  for (int i = 0; i < count; ++i) {
    const EdgeMatch& match = matches[static_cast<std::size_t>(i)];
    const double depth_m = (pose * glm::dvec4(match.match.point_world_m, 1.0)).z;
    const EdgeGroup& of = group_of[static_cast<std::size_t>(i)];
    // Along the group's normal: displacements of opposite normals must not cancel.
    const double offset_px =
        of.sign * match.root_weight *
        std::hypot(mesh_sigma_m * view.Intrinsics().fx_px / depth_m, kGroupSigmaPx);
    const auto group = static_cast<Eigen::Index>(of.number);
    offsets[i] = offset_px;
    pulls.col(group) += jacobian.row(i).transpose() * offset_px;
    means.row(group) += jacobian.row(i) / offset_px;
    mean_residual[group] += residuals[i] / offset_px;
    sizes[group] += 1.0;
  }
  for (Eigen::Index group = 0; group < groups; ++group) {
    means.row(group) /= sizes[group];
    mean_residual[group] /= sizes[group];
  }
  // The part of each group's displacement that remains in each group's mean residual once the pose
  // is fitted. Groups count by their samples.
  const Eigen::MatrixXd left = Eigen::MatrixXd::Identity(groups, groups) - means * inverse * pulls;
  const double one_group = sizes.squaredNorm() / sizes.sum();
  const double expected = sizes.dot(left.rowwise().squaredNorm()) / one_group;
  const double found = sizes.dot(mean_residual.array().square().matrix()) / one_group;
  // The stated deviation counts as much as one group.
  constexpr double kStatedGroups = 1.0;
  const double freedom = kStatedGroups + expected;
  const double scale = (kStatedGroups + found) / freedom;
  // A scale that few groups give is itself uncertain, as Student's t is wider than a normal error.
  const double few = freedom / (freedom - std::min(1.0, 0.5 * freedom));
  double squares = 0.0;
  for (int i = 0; i < count; ++i) {
    const auto group = static_cast<Eigen::Index>(group_of[static_cast<std::size_t>(i)].number);
    const double about = residuals[i] - mean_residual[group] * offsets[i];
    squares += about * about;
  }
  const double variance = squares / std::max(1.0, static_cast<double>(count - groups));
  const Eigen::Matrix<double, 6, 6> by_groups =
      inverse * (pulls * pulls.transpose()) * inverse * (few * scale);
  return by_groups + variance * inverse;
}

}  // namespace

void EdgePoseOptions::Validate() const {
  RequireOption(reach_px > 1.0 && std::isfinite(reach_px), "reach_px", reach_px, "above 1");
  RequireOption(mesh_sigma_m >= 0.0 && std::isfinite(mesh_sigma_m),
                "mesh_sigma_m",
                mesh_sigma_m,
                "0 or more");
  RequireOption(largest_rotation_sigma_rad > 0.0,
                "largest_rotation_sigma_rad",
                largest_rotation_sigma_rad,
                "above 0");
  RequireOption(largest_position_sigma_m > 0.0,
                "largest_position_sigma_m",
                largest_position_sigma_m,
                "above 0");
}

tl::expected<EdgePose, UndeterminedPose> RefinePoseByEdges(
    const Lens& lens,
    const Rgb8Image& picture,
    const EdgeModel& model,
    const glm::dmat4& rough_camera_from_world,
    const EdgePoseOptions& options) {
  options.Validate();
  const CameraIntrinsics& intrinsics = lens.Intrinsics();
  RequireLensSize(intrinsics, picture);
  const EdgeView view(lens, model);
  const PictureSlopes coarse(picture, 2.5);
  const PictureSlopes fine(picture, 1.0);
  const double reach = options.reach_px;
  if (view.PlacesOf(rough_camera_from_world, fine).size() < kFewestEdgePlaces) {
    return tl::unexpected(
        OpenPose("the rough pose has hardly an edge of the mesh in view, expected some that are " +
                 NumberText("%.0f px long together", kFewestEdgePlaces * kEdgePlaceStepPx)));
  }

  // Starts turned so that the picture shifts by up to the reach.
  struct Try {
    glm::dmat4 pose;
    double support;
  };
  std::vector<Try> tries;
  // From each start, edges are searched over the entire reach, and also only nearby. A wide search
  // goes to the strongest edges, a narrow one to those that fit best.
  const std::vector<Stage> wide{{reach, 0.3 * reach, 6, 0.3},
                                {0.5 * reach, 0.15 * reach, 6, 0.15},
                                {0.3 * reach, kNearPx, 6, 0.05}};
  const std::vector<Stage> narrow{{0.5 * reach, kNearPx, 8, 0.1}};
  for (const double pan : {0.0, -0.4, 0.4, -0.8, 0.8}) {
    for (const double tilt : {0.0, -0.4, 0.4, -0.8, 0.8}) {
      for (const std::vector<Stage>* stages : {&wide, &narrow}) {
        std::optional<glm::dmat4> pose = Turned(rough_camera_from_world,
                                                pan * reach / intrinsics.fx_px,
                                                tilt * reach / intrinsics.fy_px);
        for (const Stage& stage : *stages) {
          if (pose) pose = Moved(view, coarse, stage, rough_camera_from_world, *pose);
        }
        if (pose) pose = Moved(view, fine, {6.0, kNearPx, 8}, rough_camera_from_world, *pose);
        if (pose) tries.push_back({*pose, Support(view, fine, *pose)});
      }
    }
  }
  std::stable_sort(
      tries.begin(), tries.end(), [](const Try& a, const Try& b) { return a.support > b.support; });
  std::optional<glm::dmat4> best;
  if (!tries.empty()) {
    best = Moved(view,
                 fine,
                 {4.0, 0.5 * kNearPx, 30, 0.0, kMostEdgePlaces},
                 rough_camera_from_world,
                 tries[0].pose);
  }
  if (!best) {
    return tl::unexpected(OpenPose("the picture has too few edges near those of the mesh"));
  }
  EdgePose result;
  result.camera_from_world = *best;
  std::vector<EdgePlace> samples = view.PlacesOf(*best, fine);
  std::vector<EdgePlace> counting;
  double squares = 0.0;
  double others_per_px = 0.0;
  constexpr double kFarPx = 16.0;
  for (EdgePlace& sample : samples) {
    sample.steps_px = StepsAlong(fine, sample, kFarPx);
    for (const double step : sample.steps_px) {
      if (std::abs(step) > 2.0 * kNearPx) others_per_px += 1.0 / (2.0 * (kFarPx - 2.0 * kNearPx));
    }
    const double nearest = sample.NearestPx();
    if (!(std::abs(nearest) <= kNearPx)) continue;
    squares += nearest * nearest;
    counting.push_back(sample);
  }
  const double count = static_cast<double>(samples.size());
  if (samples.size() < kFewestEdgePlaces || counting.size() < kFewestEdgePlaces / 2) {
    return tl::unexpected(OpenPose("hardly an edge of the mesh is found in the picture"));
  }
  result.rms_px = std::sqrt(squares / static_cast<double>(counting.size()));
  result.found_share = static_cast<double>(counting.size()) / count;
  result.chance_share = 1.0 - std::exp(-2.0 * kNearPx * others_per_px / count);
  const PoseCandidate candidate{*best, result.rms_px};
  const std::string found = NumberText("%.0f %%", 100.0 * result.found_share) +
                            " of the mesh's edges are found in the picture, where chance finds " +
                            NumberText("%.0f %%", 100.0 * result.chance_share) +
                            " (reprojection error " + NumberText("%.2f px", result.rms_px) + ")";
  if (!(result.found_share >= result.chance_share + kLeastShareOverChance)) {
    return tl::unexpected(OpenPose(found, {candidate}));
  }
  const Eigen::Matrix<double, 6, 6> covariance =
      CovarianceOf(view, MatchesOf(counting, 0.5 * kNearPx), *best, options.mesh_sigma_m);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of_rotation(
      Eigen::Matrix3d(covariance.topLeftCorner<3, 3>()), Eigen::EigenvaluesOnly);
  result.rotation_sigma_rad = std::sqrt(of_rotation.eigenvalues()[2]);
  result.position_sigma_m = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
  for (int axis = 0; axis < 3; ++axis) {
    result.axis_rotation_sigma_rad[axis] = std::sqrt(covariance(axis, axis));
    result.axis_position_sigma_m[axis] = std::sqrt(covariance(3 + axis, 3 + axis));
  }
  if (!(result.rotation_sigma_rad <= options.largest_rotation_sigma_rad &&
        result.position_sigma_m <= options.largest_position_sigma_m)) {
    return tl::unexpected(
        OpenPose("the edges leave it open to " +
                     NumberText("%.2f deg", DegFromRad(result.rotation_sigma_rad)) + " and " +
                     NumberText("%.2f m", result.position_sigma_m) + "; " + found,
                 {candidate}));
  }
  const double shift_px = ShiftPx(view, fine, rough_camera_from_world, *best);
  if (!(shift_px <= 1.5 * reach)) {
    return tl::unexpected(OpenPose("the best pose moves the mesh's edges by " +
                                   PixelText(shift_px) + ", expected at most " +
                                   PixelText(1.5 * reach)));
  }
  for (const Try& other : tries) {
    if (!(other.support >= kRivalShare * tries[0].support)) break;
    const double apart_px = ShiftPx(view, fine, *best, other.pose);
    if (apart_px <= 2.0 * kNearPx) continue;
    return tl::unexpected(OpenPose("two poses fit the edges nearly as well, with the picture " +
                                       PixelText(apart_px) + " apart",
                                   {{*best, 0.0}, {other.pose, 0.0}}));
  }
  return result;
}

}  // namespace pleinair

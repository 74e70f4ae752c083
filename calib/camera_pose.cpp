#include "calib/camera_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <opencv2/core.hpp>

#include "calib/internal/check_number.h"
#include "calib/internal/point_spread.h"
#include "calib/internal/pose_refinement.h"
#include "calib/internal/pose_search.h"
#include "calib/internal/residual_text.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

// Poses this close in rotation are one.
constexpr double kSamePoseRad = 0.02;
// 5 standard deviations: see the header.
constexpr double kChoosesFrom = 25.0;

std::string Degrees(double rad) { return NumberText("%.1f deg", DegFromRad(rad)); }

UndeterminedPose Undetermined(const std::string& why, std::vector<PoseCandidate> candidates = {}) {
  return {"the camera's pose cannot be determined: " + why, std::move(candidates)};
}

glm::dvec3 CentreOf(const glm::dmat4& camera_from_world) {
  return glm::dvec3(glm::inverse(camera_from_world)[3]);
}

bool OnALine(std::span<const PointMatch> matches) {
  std::vector<glm::dvec3> points;
  for (const PointMatch& match : matches) points.push_back(match.point_world_m);
  return SpreadOf(points).IsALine();
}

double RmsPx(double sum_squares, std::size_t count) {
  return std::sqrt(sum_squares / static_cast<double>(count));
}

// A hypothesis with its own matches fitted, counted again, and so on.
struct Fitted {
  RefinedPose refined;
  std::vector<PointMatch> inliers;
  ScoredPose scored;
};

std::optional<Fitted> Fit(const PoseSearch& search, const glm::dmat4& start) {
  constexpr int kRounds = 4;
  std::optional<Fitted> fitted;
  glm::dmat4 pose = start;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<PointMatch> inliers = search.InliersOf(pose);
    if (inliers.size() < kFewestMatches) break;
    const auto refined = RefinePose(search.Intrinsics(), inliers, pose);
    if (!refined) break;
    const ScoredPose scored = search.Score(refined->camera_from_world);
    if (fitted && !(scored.cost < fitted->scored.cost)) break;
    pose = refined->camera_from_world;
    fitted = Fitted{*refined, std::move(inliers), scored};
  }
  return fitted;
}

std::optional<Fitted> BestFit(const PoseSearch& search, const std::vector<ScoredPose>& hypotheses) {
  constexpr std::size_t kTried = 6;
  std::optional<Fitted> best;
  std::vector<glm::dmat4> tried;
  for (const ScoredPose& hypothesis : hypotheses) {
    if (tried.size() >= kTried) break;
    if (std::any_of(tried.begin(), tried.end(), [&](const glm::dmat4& other) {
          return RotationBetweenRad(other, hypothesis.pose) < kSamePoseRad;
        })) {
      continue;
    }
    tried.push_back(hypothesis.pose);
    auto fitted = Fit(search, hypothesis.pose);
    if (fitted && (!best || fitted->scored.cost < best->scored.cost)) best = std::move(fitted);
  }
  return best;
}

// The best pose of the same matches that is another one.
std::optional<RefinedPose> RivalOf(const Fitted& best,
                                   const PoseSearch& search,
                                   const std::vector<ScoredPose>& hypotheses) {
  constexpr std::size_t kTried = 8;
  std::vector<glm::dmat4> starts = search.FlatPosesOf(best.inliers);
  for (const ScoredPose& hypothesis : hypotheses) {
    if (starts.size() >= kTried) break;
    if (std::none_of(starts.begin(), starts.end(), [&](const glm::dmat4& other) {
          return RotationBetweenRad(other, hypothesis.pose) < kSamePoseRad;
        })) {
      starts.push_back(hypothesis.pose);
    }
  }
  std::optional<RefinedPose> rival;
  for (const glm::dmat4& start : starts) {
    const auto refined = RefinePose(search.Intrinsics(), best.inliers, start);
    if (!refined || RotationBetweenRad(refined->camera_from_world, best.refined.camera_from_world) <
                        kSamePoseRad) {
      continue;
    }
    // Before the camera, as far as the lens is good.
    if (!std::isfinite(search.ResidualPx(refined->camera_from_world, best.inliers[0]))) continue;
    if (!rival || refined->sum_squares_px < rival->sum_squares_px) rival = refined;
  }
  return rival;
}

// A flat board seen nearly from the front tilts either way with little to choose between: the
// pose's own mirrored one, where the matches leave it open.
std::optional<glm::dmat4> OpenTwinOf(const Fitted& best,
                                     const PoseSearch& search,
                                     double variance) {
  std::vector<PointMatch> exact = best.inliers;
  for (PointMatch& match : exact) {
    const auto pixel = search.Project(best.refined.camera_from_world, match);
    if (!pixel) return std::nullopt;
    match.pixel = *pixel;
  }
  for (const glm::dmat4& twin : search.FlatPosesOf(exact)) {
    if (RotationBetweenRad(twin, best.refined.camera_from_world) < kSamePoseRad) continue;
    double sum_squares = 0.0;
    for (const PointMatch& match : best.inliers) {
      sum_squares += std::pow(search.ResidualPx(twin, match), 2.0);
    }
    if (sum_squares - best.refined.sum_squares_px < kChoosesFrom * variance) return twin;
  }
  return std::nullopt;
}

UndeterminedPose TooFew(const PoseSearch& search, std::size_t count, bool on_a_line) {
  std::string why = std::to_string(count) + (count == 1 ? " point" : " points");
  std::vector<PoseCandidate> candidates;
  if (count == 3 && !on_a_line) {
    std::vector<glm::dmat4> poses;
    search.AddFromTriple({0, 1, 2}, poses);
    for (const glm::dmat4& pose : poses) {
      const ScoredPose scored = search.Score(pose);
      if (scored.inliers == 3) candidates.push_back({pose, RmsPx(scored.cost, 3)});
    }
    std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
      return a.rms_px < b.rms_px;
    });
    why += " leave " + std::to_string(candidates.size()) + " poses open";
    if (!candidates.empty()) why += " (reprojection error " + PixelText(candidates[0].rms_px) + ")";
  }
  return Undetermined(why + ", expected 4 or more", std::move(candidates));
}

}  // namespace

void CameraPoseOptions::Validate() const {
  RequireOption(inlier_px > 0.0 && std::isfinite(inlier_px), "inlier_px", inlier_px, "above 0");
  RequireOption(point_sigma_px > 0.0 && std::isfinite(point_sigma_px),
                "point_sigma_px",
                point_sigma_px,
                "above 0");
  RequireOption(least_share >= 0.0 && least_share <= 1.0, "least_share", least_share, "0 to 1");
  RequireOption(largest_rotation_sigma_rad > 0.0,
                "largest_rotation_sigma_rad",
                largest_rotation_sigma_rad,
                "above 0");
}

double RotationBetweenRad(const glm::dmat4& a, const glm::dmat4& b) {
  const glm::dmat3 turn = glm::dmat3(a) * glm::transpose(glm::dmat3(b));
  const glm::dvec3 axis_times_2_sin(
      turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);
  return std::atan2(glm::length(axis_times_2_sin), turn[0][0] + turn[1][1] + turn[2][2] - 1.0);
}

tl::expected<CameraPose, UndeterminedPose> FindCameraPose(
    const Lens& lens,
    std::span<const PointMatch> matches,
    const CameraPoseOptions& options,
    const std::optional<glm::dmat4>& expected_camera_from_world) {
  options.Validate();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const PointMatch& match = matches[i];
    for (const double value : {match.point_world_m.x,
                               match.point_world_m.y,
                               match.point_world_m.z,
                               match.pixel.x,
                               match.pixel.y}) {
      if (std::isfinite(value)) continue;
      throw std::invalid_argument("match " + std::to_string(i) +
                                  ": expected finite coordinates, found " +
                                  NumberText("%g", value));
    }
  }
  const PoseSearch search(lens, matches, options);
  const bool on_a_line = matches.size() >= 2 && OnALine(matches);
  if (matches.size() < kFewestMatches) {
    return tl::unexpected(TooFew(search, matches.size(), on_a_line));
  }
  const std::string on_one_line = "the points lie on one line, expected some beside it";
  if (on_a_line) return tl::unexpected(Undetermined(on_one_line));

  const std::vector<ScoredPose> hypotheses = search.Hypotheses();
  const auto best = BestFit(search, hypotheses);
  const auto needed = std::max(static_cast<double>(kFewestMatches),
                               options.least_share * static_cast<double>(matches.size()));
  if (!best || static_cast<double>(best->scored.inliers) < needed) {
    std::vector<PoseCandidate> nearest;
    std::string error;
    if (!hypotheses.empty()) {
      nearest.push_back({hypotheses[0].pose, RmsPx(hypotheses[0].cost, matches.size())});
      error = " (reprojection error " + PixelText(nearest[0].rms_px) + " or more)";
    }
    return tl::unexpected(Undetermined(
        std::string("no pose fits more than ") +
            std::to_string(best                 ? best->scored.inliers
                           : hypotheses.empty() ? 0
                                                : hypotheses[0].inliers) +
            " of " + std::to_string(matches.size()) + " points to " + PixelText(options.inlier_px) +
            ", expected " + NumberText("%.0f", std::ceil(needed)) + error,
        std::move(nearest)));
  }
  if (OnALine(best->inliers)) return tl::unexpected(Undetermined(on_one_line));

  const RefinedPose* chosen = &best->refined;
  const auto rival = RivalOf(*best, search, hypotheses);
  const std::size_t count = best->inliers.size();
  // 2 count residuals, 6 of them spent on the pose.
  const double variance =
      std::max(options.point_sigma_px * options.point_sigma_px,
               best->refined.sum_squares_px / static_cast<double>(2 * count - 6));
  const auto candidate = [&](const RefinedPose& pose) {
    return PoseCandidate{pose.camera_from_world, RmsPx(pose.sum_squares_px, count)};
  };
  const bool two_fit =
      rival && rival->sum_squares_px - best->refined.sum_squares_px < kChoosesFrom * variance;
  if (two_fit) {
    if (!expected_camera_from_world) {
      const PoseCandidate first = candidate(best->refined);
      const PoseCandidate second = candidate(*rival);
      return tl::unexpected(Undetermined(
          "two poses " +
              Degrees(RotationBetweenRad(first.camera_from_world, second.camera_from_world)) +
              " apart fit the points (reprojection errors " + PixelText(first.rms_px) + " and " +
              PixelText(second.rms_px) + "), expected points off one plane, or a larger picture",
          {first, second}));
    }
    if (RotationBetweenRad(rival->camera_from_world, *expected_camera_from_world) <
        RotationBetweenRad(best->refined.camera_from_world, *expected_camera_from_world)) {
      chosen = &*rival;
    }
  }

  CameraPose pose;
  pose.camera_from_world = chosen->camera_from_world;
  pose.rms_px = RmsPx(chosen->sum_squares_px, count);
  cv::Matx<double, 6, 6> normal;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) normal(row, column) = chosen->normal(row, column);
  }
  const cv::Matx<double, 6, 6> covariance = variance * normal.inv(cv::DECOMP_LU);
  cv::Vec3d of_rotation;  // Largest first.
  cv::eigen(covariance.get_minor<3, 3>(0, 0), of_rotation);
  pose.rotation_sigma_rad = std::sqrt(of_rotation[0]);
  pose.position_sigma_m = std::sqrt(cv::trace(covariance.get_minor<3, 3>(3, 3)));
  if (!two_fit) {
    if (const auto twin = OpenTwinOf(*best, search, variance)) {
      const double apart_rad = RotationBetweenRad(*twin, pose.camera_from_world);
      const double apart_m = glm::distance(CentreOf(*twin), CentreOf(pose.camera_from_world));
      pose.rotation_sigma_rad = std::max(pose.rotation_sigma_rad, 0.5 * apart_rad);
      pose.position_sigma_m = std::max(pose.position_sigma_m, 0.5 * apart_m);
    }
  }
  if (!(pose.rotation_sigma_rad <= options.largest_rotation_sigma_rad) ||
      !std::isfinite(pose.position_sigma_m)) {
    return tl::unexpected(
        Undetermined("the points leave its rotation open to " +
                         (std::isfinite(pose.rotation_sigma_rad) ? Degrees(pose.rotation_sigma_rad)
                                                                 : std::string("any angle")) +
                         " (reprojection error " + PixelText(pose.rms_px) + "), expected " +
                         Degrees(options.largest_rotation_sigma_rad) + " or less",
                     {candidate(*chosen)}));
  }
  for (const PointMatch& match : matches) {
    pose.residual_px.push_back(search.ResidualPx(pose.camera_from_world, match));
    pose.counts.push_back(pose.residual_px.back() <= options.inlier_px);
  }
  if (rival) pose.rival = candidate(chosen == &best->refined ? *rival : best->refined);
  return pose;
}

}  // namespace pleinair

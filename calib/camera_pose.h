// The pose of a calibrated camera, from world points that were found in its picture.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "calib/lens.h"

namespace pleinair {

// A world point and its pixel.
struct PointMatch {
  glm::dvec3 point_world_m{0.0};
  glm::dvec2 pixel{0.0};  // In the picture as the camera took it: distorted.
};

// Limits and noise of FindCameraPose.
struct CameraPoseOptions {
  double inlier_px = 3.0;  // A match that is farther off does not count; above 0.
  // Standard deviation of a point's coordinate at best; above 0. Residuals may increase it.
  double point_sigma_px = 0.3;
  double least_share = 0.5;  // Share of the matches that must agree on one pose; 0 to 1.
  // A pose whose rotation is known less well is no pose; above 0.
  double largest_rotation_sigma_rad = 0.1;
  std::uint64_t seed = 1;  // Seed of the triples that are tried, where there are too many for all.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// For points that a person picked in the picture: found to some pixel, not to a third of one.
inline CameraPoseOptions PickedPointOptions() {
  CameraPoseOptions options;
  options.inlier_px = 3.0;
  options.point_sigma_px = 0.7;  // Deviation of one coordinate.
  return options;
}

// A pose that the points fit, or nearly.
struct PoseCandidate {
  glm::dmat4 camera_from_world{1.0};
  double rms_px = 0.0;  // Over the inliers: the root of the mean squared distance.
};

// A pose and its accuracy.
struct CameraPose {
  glm::dmat4 camera_from_world{1.0};
  double rms_px = 0.0;              // As PoseCandidate's.
  std::vector<double> residual_px;  // One for each match; infinite where the point is out of view.
  std::vector<bool> counts;         // False: a wrong match.
  // Standard deviations from the residuals' own size, or point_sigma_px where that is larger.
  double rotation_sigma_rad = 0.0;  // About the worst axis.
  double position_sigma_m = 0.0;    // For the camera's centre, all three axes together.
  // The second-best pose, where the points have one (flat boards have a mirrored one).
  std::optional<PoseCandidate> rival;
};

// Why there is no pose.
struct UndeterminedPose {
  std::string reason;  // One line, with the reprojection error where there is one.
  std::vector<PoseCandidate> candidates;  // The closest poses, best first.
};

// Returns the pose that most matches agree on, by least squares over those within inlier_px of it.
// Or the reason why there is none: fewer than 4 matches, points on a line, or no pose that
// least_share of them agree on. Also an undetermined rotation, or two poses that the points do not
// distinguish. Points distinguish two poses where the summed squares of the second are larger by 25
// variances of a point's coordinate. Else `expected_camera_from_world`, where given, decides: the
// pose with the nearer rotation is taken.
//
// Source   Triples by Ke and Roumeliotis, CVPR 2017 (cv::SOLVEPNP_AP3P). The two poses of a flat
//          board by Collins and Bartoli, IJCV 109(3), 2014 (cv::SOLVEPNP_IPPE), with the points
//          projected onto their plane, so that nearly flat boards work too.
// Cost     some 3 ms of one thread for 30 matches; up to ten times that where half are wrong.
// Throws   std::invalid_argument for a match that is not finite, and as Validate.
tl::expected<CameraPose, UndeterminedPose> FindCameraPose(
    const Lens& lens,
    std::span<const PointMatch> matches,
    const CameraPoseOptions& options = {},
    const std::optional<glm::dmat4>& expected_camera_from_world = std::nullopt);

// The angle between the two rotations.
double RotationBetweenRad(const glm::dmat4& a, const glm::dmat4& b);

}  // namespace pleinair

#include "calib/camera_pose.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sunmodel/angles.h"
#include "tests/calib/marker_scene.h"

namespace pleinair::camera_pose_test {
namespace {

// Points in a box of 2 x 2 x 1 m, seen by `pose` with normal noise a coordinate.
std::vector<PointMatch> Seen(const glm::dmat4& pose, int count, double noise_px, unsigned seed) {
  const Lens lens(MarkerCamera());
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> where(-1.0, 1.0);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<PointMatch> matches;
  while (matches.size() < static_cast<std::size_t>(count)) {
    const glm::dvec3 point(where(random), where(random), 0.5 * where(random));
    const auto pixel = lens.ProjectToPixel(glm::dvec3(pose * glm::dvec4(point, 1.0)));
    if (!pixel) continue;
    matches.push_back({point, *pixel + noise_px * glm::dvec2(noise(random), noise(random))});
  }
  return matches;
}

// Exact points give the exact pose: what is left is rounding and the end of the descent.
TEST(CameraPose, IsExactForExactPoints) {
  const Lens lens(MarkerCamera());
  for (unsigned seed = 0; seed < 20; ++seed) {
    const glm::dmat4 truth = LookAt({3.0 * std::cos(seed), 3.0 * std::sin(seed), 1.5}, {0, 0, 0});
    const auto pose = FindCameraPose(lens, Seen(truth, 12, 0.0, seed));
    ASSERT_TRUE(pose) << pose.error().reason;
    EXPECT_LT(pose->rms_px, 1e-6);
    EXPECT_LT(RotationBetweenRad(pose->camera_from_world, truth), 1e-7);
    EXPECT_LT(glm::distance(CentreOfPose(pose->camera_from_world), CentreOfPose(truth)), 1e-6);
  }
}

// Errors over their reported sigmas. 200 draws: the mean of 3 squared standard normals
// over 3 is 1 to 0.058; three times that.
TEST(CameraPose, StatesItsOwnUncertainty) {
  constexpr int kDraws = 200;
  const Lens lens(MarkerCamera());
  const glm::dmat4 truth = LookAt({2.0, -2.0, 1.5}, {0, 0, 0});
  double squares = 0.0;
  double rms_px = 0.0;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    CameraPoseOptions options;
    options.point_sigma_px = 0.4;
    options.inlier_px = 5.0;
    const auto pose = FindCameraPose(lens, Seen(truth, 30, 0.4, seed), options);
    ASSERT_TRUE(pose) << pose.error().reason;
    const double off = glm::distance(CentreOfPose(pose->camera_from_world), CentreOfPose(truth));
    squares += std::pow(off / pose->position_sigma_m, 2.0) / kDraws;
    rms_px += pose->rms_px / kDraws;
    EXPECT_LT(RotationBetweenRad(pose->camera_from_world, truth), 6.0 * pose->rotation_sigma_rad);
  }
  // The sigma is the larger of what was stated and what was seen: at most 10 % too large.
  EXPECT_NEAR(squares, 0.95, 0.2);
  EXPECT_NEAR(rms_px, 0.4 * std::sqrt(2.0 * 54.0 / 60.0), 0.02);
}

// The order of the matches is no part of the question; the pose of several markers is searched
// by all triples.
TEST(CameraPose, DoesNotDependOnTheWorldsFrame) {
  const Lens lens(MarkerCamera());
  const glm::dmat4 truth = LookAt({2.0, -2.0, 1.5}, {0, 0, 0});
  const std::vector<PointMatch> matches = Seen(truth, 10, 0.2, 5);
  const glm::dmat4 moved_from_world = glm::rotate(
      glm::translate(glm::dmat4(1.0), glm::dvec3(300.0, -200.0, 40.0)), 0.8, glm::dvec3(1, 2, 3));
  std::vector<PointMatch> moved = matches;
  for (PointMatch& match : moved) {
    match.point_world_m = glm::dvec3(moved_from_world * glm::dvec4(match.point_world_m, 1.0));
  }
  const auto here = FindCameraPose(lens, matches);
  const auto there = FindCameraPose(lens, moved);
  ASSERT_TRUE(here && there);
  const glm::dmat4 back = there->camera_from_world * moved_from_world;
  // 300 m of origin: 1e-13 of that, times the descent's own 1e-6.
  EXPECT_LT(RotationBetweenRad(here->camera_from_world, back), 1e-6);
  EXPECT_LT(glm::distance(CentreOfPose(here->camera_from_world), CentreOfPose(back)), 1e-5);
}

}  // namespace
}  // namespace pleinair::camera_pose_test

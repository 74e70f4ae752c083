#include "calib/timed_pose.h"

#include <chrono>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/camera_pose.h"
#include "tests/calib/marker_scene.h"

namespace pleinair::timed_pose_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

UtcTime At(int ms) { return UtcTime(std::chrono::sys_days{2026y / 6 / 21}) + ms * 1ms; }

double LargestDifference(const glm::dmat4& a, const glm::dmat4& b) {
  double largest = 0.0;
  for (int c = 0; c < 4; ++c) {
    for (int r = 0; r < 4; ++r) largest = std::max(largest, std::abs(a[c][r] - b[c][r]));
  }
  return largest;
}

TEST(PoseChange, LeadsFromOnePoseToTheOther) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-3.0, 3.0);
  const auto draw = [&] { return glm::dvec3(any(random), any(random), any(random)); };
  for (int i = 0; i < 1000; ++i) {
    const glm::dmat4 from = LookAt(draw(), draw() + glm::dvec3(9.0, 0.0, 0.0));
    const glm::dmat4 to = LookAt(draw(), draw() - glm::dvec3(9.0, 0.0, 0.0));
    const PoseChange change = ChangeBetween(from, to);
    EXPECT_LE(glm::length(change.turned_rad), 3.1415926536) << i;
    // Products of a few rounding errors of numbers up to 20.
    EXPECT_LT(LargestDifference(Changed(from, change), to), 1e-12) << i;
  }
  const glm::dmat4 pose = LookAt({1.0, -2.0, 1.0}, {0.0, 0.0, 0.5});
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 3.14159}) {
    const PoseChange change{{0.1, 0.2, 0.3}, {0.0, angle, 0.0}};
    const PoseChange again = ChangeBetween(pose, Changed(pose, change));
    EXPECT_LT(glm::distance(again.turned_rad, change.turned_rad), 1e-12) << angle;
    EXPECT_LT(glm::distance(again.moved_m, change.moved_m), 1e-14) << angle;
  }
}

TEST(PoseChange, DoesNotDependOnTheOrigin) {
  const PoseChange change{{0.002, -0.001, 0.003}, {1e-3, -2e-3, 5e-4}};
  const glm::dvec3 far(5e5, 6e6, 100.0);
  const glm::dmat4 near_pose = LookAt({1.0, -2.0, 1.0}, {0.0, 0.0, 0.5});
  const glm::dmat4 far_pose = LookAt(far + glm::dvec3(1.0, -2.0, 1.0), far + glm::dvec3(0, 0, 0.5));
  EXPECT_LT(glm::distance(CentreOfPose(Changed(far_pose, change)) - far,
                          CentreOfPose(Changed(near_pose, change))),
            1e-7);  // 6e6 times a few rounding errors.
}

TEST(PoseBetween, MovesStraightAndTurnsAboutOneAxis) {
  const TimedPose first{At(0), LookAt({0.0, -2.0, 1.0}, {0.0, 0.0, 1.0})};
  // A quarter turn to the left about z while it moves by 4 m.
  const TimedPose second{At(100), LookAt({4.0, -2.0, 1.0}, {0.0, -2.0, 1.0})};
  const glm::dmat4 quarter = PoseBetween(first, second, At(25));
  EXPECT_LT(glm::distance(CentreOfPose(quarter), {1.0, -2.0, 1.0}), 1e-12);
  EXPECT_NEAR(RotationBetweenRad(first.camera_from_world, quarter), 3.14159265358979 / 8.0, 1e-12);
  EXPECT_NEAR(
      RotationBetweenRad(quarter, second.camera_from_world), 3.0 * 3.14159265358979 / 8.0, 1e-12);
  EXPECT_EQ(FaultOfPose(quarter), "");
}

TEST(PoseBetween, StandsStillOutsideAndAtOneTime) {
  const TimedPose first{At(0), LookAt({0.0, -2.0, 1.0}, {0.0, 0.0, 1.0})};
  const TimedPose second{At(100), LookAt({1.0, -2.0, 1.0}, {1.0, 0.0, 1.0})};
  EXPECT_EQ(PoseBetween(first, second, At(-5)), first.camera_from_world);
  EXPECT_EQ(PoseBetween(first, second, At(0)), first.camera_from_world);
  EXPECT_EQ(PoseBetween(first, second, At(100)), second.camera_from_world);
  EXPECT_EQ(PoseBetween(first, second, At(105)), second.camera_from_world);
  const TimedPose same_time{At(0), second.camera_from_world};
  EXPECT_EQ(PoseBetween(first, same_time, At(0)), same_time.camera_from_world);
}

TEST(SecondsFromTo, HoldsForAllTimes) {
  EXPECT_DOUBLE_EQ(SecondsFromTo(At(0), At(33)), 0.033);
  EXPECT_DOUBLE_EQ(SecondsFromTo(At(33), At(0)), -0.033);
  EXPECT_NEAR(SecondsFromTo(UtcTime::min(), UtcTime::max()), 1.8446744073709552e10, 1e-3);
  const TimedPose first{UtcTime::min(), LookAt({0.0, -2.0, 1.0}, {0.0, 0.0, 1.0})};
  const TimedPose last{UtcTime::max(), LookAt({1.0, -2.0, 1.0}, {1.0, 0.0, 1.0})};
  EXPECT_NEAR(CentreOfPose(PoseBetween(first, last, UtcTime{})).x, 0.5, 1e-9);
}

TEST(FaultOfPose, RefusesWhatIsNoPose) {
  const glm::dmat4 pose = LookAt({0.0, -2.0, 1.0}, {0.0, 0.0, 1.0});
  EXPECT_EQ(FaultOfPose(pose), "");
  glm::dmat4 mirrored = pose;
  for (int c = 0; c < 4; ++c) mirrored[c][0] = -mirrored[c][0];
  EXPECT_THAT(FaultOfPose(mirrored), HasSubstr("mirror"));
  glm::dmat4 scaled = pose;
  scaled[1] *= 1.001;
  EXPECT_THAT(FaultOfPose(scaled), HasSubstr("rigid"));
  EXPECT_THAT(FaultOfPose(scaled), HasSubstr("axes of lengths 1, 1.001 and 1"));
  glm::dmat4 skewed = pose;
  skewed[1] = glm::normalize(pose[1] + 0.01 * pose[0]);
  EXPECT_THAT(FaultOfPose(skewed), HasSubstr("not at right angles"));
  EXPECT_THAT(FaultOfPose(glm::transpose(pose)), HasSubstr("translation is the last column"));
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    glm::dmat4 not_finite = pose;
    not_finite[3][1] = bad;
    EXPECT_THAT(FaultOfPose(not_finite), HasSubstr("of finite numbers"));
    not_finite = pose;
    not_finite[0][1] = bad;
    EXPECT_THAT(FaultOfPose(not_finite), HasSubstr("of finite numbers"));
  }
  EXPECT_THAT(FaultOfPose(glm::dmat4(0.0)), HasSubstr("rigid"));
}

}  // namespace
}  // namespace pleinair::timed_pose_test

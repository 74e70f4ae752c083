// Dirty streams of poses: see also pose_filter_test.cpp.
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/pose_filter.h"
#include "tests/calib/noisy_poses.h"

namespace pleinair::pose_filter_hard_cases_test {
namespace {

using testing::HasSubstr;

constexpr double kNoisePx = 0.5;

glm::dmat4 Standing(double x_m = 0.0) { return LookAt({x_m, -5.0, 1.6}, {x_m, 0.0, 1.0}); }

// A filter that has seen so many frames of a camera at rest.
struct Settled {
  explicit Settled(int frames = 90, unsigned seed = 1) : noisy(kNoisePx, seed) {
    for (int i = 0; i < frames; ++i) Update(FrameTime(i), noisy.Of(Standing()));
  }
  glm::dmat4 Update(UtcTime time, const glm::dmat4& pose) {
    return filter.Update(TrackedCamera(), {time, pose}, state);
  }

  PoseFilter filter;
  PoseFilterState state;
  NoisyPoses noisy;
};

TEST(PoseFilterHardCases, AMirroredOrTornPoseIsRefusedAndLeavesTheStateAlone) {
  Settled settled;
  const glm::dmat4 before = settled.state.last_result;
  glm::dmat4 mirrored = Standing();
  for (int c = 0; c < 4; ++c) mirrored[c][1] = -mirrored[c][1];
  glm::dmat4 stretched = Standing();
  stretched[0] *= 2.0;
  glm::dmat4 not_finite = Standing();
  not_finite[3].z = std::numeric_limits<double>::quiet_NaN();
  for (const glm::dmat4& bad : {mirrored, stretched, not_finite}) {
    try {
      settled.Update(FrameTime(90), bad);
      FAIL() << "accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("camera pose: expected a r"));
      EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
    }
  }
  EXPECT_EQ(settled.state.recent.size(), 90u);
  EXPECT_EQ(settled.state.last_result, before);
}

// No time between two frames, or time that goes back: there is no run of poses to average.
TEST(PoseFilterHardCases, TimesThatDoNotAscendBeginAgain) {
  for (const int frame : {89, 40, -1000}) {
    Settled settled;
    const glm::dmat4 pose = settled.noisy.Of(Standing());
    EXPECT_EQ(settled.Update(FrameTime(frame), pose), pose) << frame;
    EXPECT_EQ(settled.state.recent.size(), 1u);
    for (int i = 1; i < 90; ++i) settled.Update(FrameTime(frame + i), settled.noisy.Of(Standing()));
    EXPECT_GT(settled.state.averaged, 60);
  }
  // A clock that stands still for good.
  Settled settled;
  for (int i = 0; i < 50; ++i) {
    const glm::dmat4 pose = settled.noisy.Of(Standing());
    const glm::dmat4 shown = settled.Update(FrameTime(100), pose);
    if (i > 0) {
      EXPECT_EQ(shown, pose);
    }
  }
}

// Poses missing for a second: where the camera went on meanwhile, its new pose holds at once; where
// it stood, the old ones still count.
TEST(PoseFilterHardCases, PosesMissingForASecond) {
  Settled moved;
  const glm::dmat4 elsewhere = moved.noisy.Of(Standing(0.5));
  EXPECT_EQ(moved.Update(FrameTime(120), elsewhere), elsewhere);
  Settled stood;
  stood.Update(FrameTime(120), stood.noisy.Of(Standing()));
  EXPECT_GT(stood.state.averaged, 30);
  EXPECT_LE(glm::length(WobblePx(Standing(), stood.state.last_result)), 0.3);
  // An hour later nothing of it counts.
  const glm::dmat4 later = stood.noisy.Of(Standing());
  EXPECT_EQ(stood.Update(FrameTime(30 * 3600), later), later);
}

TEST(PoseFilterHardCases, FramesFarApartStandForThemselves) {
  Settled empty(0);
  for (int i = 0; i < 40; ++i) {
    const glm::dmat4 pose = empty.noisy.Of(Standing());
    EXPECT_EQ(empty.Update(FrameTime(1800 * i), pose), pose);  // A minute from one to the next.
  }
}

// Half turns, the largest that there are, and back.
TEST(PoseFilterHardCases, AHalfTurnPassesAtOnce) {
  Settled settled;
  for (int i = 0; i < 12; ++i) {
    const glm::dmat4 turned =
        Changed(settled.noisy.Of(Standing()),
                {glm::dvec3(0.0), glm::dvec3(0.0, i % 2 == 0 ? 3.14159265358979 : 0.0, 0.0)});
    const glm::dmat4 shown = settled.Update(FrameTime(90 + i), turned);
    if (i % 2 == 0) {
      EXPECT_EQ(shown, turned);
    }
    EXPECT_EQ(FaultOfPose(settled.state.last_result), "");
  }
}

// One wrong pose in the middle of a rest is shown, as it may be true; it is no longer than itself.
TEST(PoseFilterHardCases, ASingleOutlierDoesNotLast) {
  Settled settled;
  const glm::dmat4 wrong = settled.noisy.Of(Standing(0.4));
  EXPECT_EQ(settled.Update(FrameTime(90), wrong), wrong);
  for (int i = 91; i < 260; ++i) {
    settled.Update(FrameTime(i), settled.noisy.Of(Standing()));
    EXPECT_LE(glm::length(WobblePx(Standing(), settled.state.last_result)), 5.0 * kNoisePx) << i;
  }
  EXPECT_GT(settled.state.averaged, 60);
}

// Survey coordinates: millions of metres from the origin, the same wobble.
TEST(PoseFilterHardCases, FarFromTheOrigin) {
  const glm::dvec3 far(5.3e5, 6.2e6, 120.0);
  const glm::dmat4 truth = LookAt(far + glm::dvec3(0, -5, 1.6), far + glm::dvec3(0, 0, 1.0));
  const PoseFilter filter;
  PoseFilterState state;
  NoisyPoses noisy(kNoisePx, 3);
  double sum = 0.0;
  for (int i = 0; i < 300; ++i) {
    const glm::dmat4 shown = filter.Update(TrackedCamera(), {FrameTime(i), noisy.Of(truth)}, state);
    const glm::dvec2 wobble = WobblePx(truth, shown);
    if (i >= 90) sum += glm::dot(wobble, wobble);
  }
  EXPECT_LE(std::sqrt(sum / 210.0), 0.08);
}

// A tracker of 1000 poses a second: bounded memory.
TEST(PoseFilterHardCases, AFastTrackerIsBounded) {
  const PoseFilter filter;
  PoseFilterState state;
  NoisyPoses noisy(kNoisePx, 3);
  for (int i = 0; i < 600; ++i) {
    filter.Update(TrackedCamera(), {FrameTime(i, 1000.0), noisy.Of(Standing())}, state);
  }
  EXPECT_LE(state.recent.size(), 256u);
  EXPECT_LE(glm::length(WobblePx(Standing(), state.last_result)), 0.1);
}

// Cameras of one pixel, and of a lens so long that a metre is out of view.
TEST(PoseFilterHardCases, OddCameras) {
  CameraIntrinsics one = TrackedCamera();
  one.width_px = one.height_px = 1;
  CameraIntrinsics tele = TrackedCamera();
  tele.fx_px = tele.fy_px = 1e6;
  for (const CameraIntrinsics& camera : {one, tele}) {
    const PoseFilter filter;
    PoseFilterState state;
    NoisyPoses noisy(kNoisePx, 3);
    for (int i = 0; i < 100; ++i) {
      const glm::dmat4 shown = filter.Update(camera, {FrameTime(i), noisy.Of(Standing())}, state);
      EXPECT_EQ(FaultOfPose(shown), "");
      EXPECT_LE(glm::length(WobblePx(Standing(), shown)), 4.0 * kNoisePx);
    }
  }
}

}  // namespace
}  // namespace pleinair::pose_filter_hard_cases_test

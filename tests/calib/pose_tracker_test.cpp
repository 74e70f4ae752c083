#include "calib/pose_tracker.h"

#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/camera_pose.h"
#include "tests/calib/marker_scene.h"

namespace pleinair::pose_tracker_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

UtcTime At(int ms) { return UtcTime(std::chrono::sys_days{2026y / 6 / 21}) + ms * 1ms; }
glm::dmat4 Standing(double x) { return LookAt({x, -2.0, 1.0}, {x, 0.0, 0.5}); }
double XOf(const glm::dmat4& pose) { return CentreOfPose(pose).x; }

TEST(PoseTracker, TakesWhatIsFound) {
  PoseTracker tracker;
  EXPECT_FALSE(tracker.Expected(At(0)));
  for (int i = 0; i < 10; ++i) {
    const auto pose = tracker.Update(At(40 * i), Standing(0.1 * i));
    ASSERT_TRUE(pose);
    EXPECT_EQ(pose->origin, PoseOrigin::kFound);
    EXPECT_EQ(pose->camera_from_world, Standing(0.1 * i));
    EXPECT_EQ(tracker.Expected(At(40 * i + 40)), Standing(0.1 * i));
  }
}

TEST(PoseTracker, CarriesForSomeFramesAndThenSaysThatItIsLost) {
  PoseTracker tracker;
  ASSERT_TRUE(tracker.Update(At(0), Standing(1.0)));
  for (int i = 1; i <= 3; ++i) {
    const auto pose = tracker.Update(At(40 * i), {}, "no marker is seen");
    ASSERT_TRUE(pose) << i;
    EXPECT_EQ(pose->origin, PoseOrigin::kCarried);
    EXPECT_EQ(pose->carried_frames, i);
    EXPECT_EQ(pose->camera_from_world, Standing(1.0));
  }
  for (int i = 4; i < 8; ++i) {
    const auto pose = tracker.Update(At(40 * i), {}, "no marker is seen");
    ASSERT_FALSE(pose) << i;
    EXPECT_EQ(pose.error(), "camera pose is not known: no marker is seen");
  }
  EXPECT_FALSE(tracker.Expected(At(320)));
  // Lost, so wherever it is found now is where it is.
  const auto again = tracker.Update(At(320), Standing(9.0));
  ASSERT_TRUE(again);
  EXPECT_EQ(XOf(again->camera_from_world), XOf(Standing(9.0)));
}

TEST(PoseTracker, CarriesForSomeTimeOnly) {
  PoseTracker tracker;
  ASSERT_TRUE(tracker.Update(At(0), Standing(1.0)));
  EXPECT_TRUE(tracker.Update(At(150), {}, "no marker is seen"));
  EXPECT_FALSE(tracker.Update(At(250), {}, "no marker is seen"));
  // What has been lost is not carried again, even for a frame that comes late.
  EXPECT_FALSE(tracker.Update(At(100), {}, "no marker is seen"));
  PoseTracker never({0, 1.0});
  ASSERT_TRUE(never.Update(At(0), Standing(1.0)));
  EXPECT_FALSE(never.Update(At(40), {}, "no marker is seen"));
}

TEST(PoseTracker, AJumpNeedsConfirmation) {
  PoseTracker tracker;
  ASSERT_TRUE(tracker.Update(At(0), Standing(0.0)));
  // A single wrong one leaves no trace but a carried frame.
  const auto jumped = tracker.Update(At(40), Standing(3.0));
  ASSERT_TRUE(jumped);
  EXPECT_EQ(jumped->origin, PoseOrigin::kCarried);
  EXPECT_EQ(jumped->camera_from_world, Standing(0.0));
  const auto back = tracker.Update(At(80), Standing(0.02));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->origin, PoseOrigin::kFound);
  // Two that agree are a camera that was moved.
  EXPECT_EQ(tracker.Update(At(120), Standing(3.0))->origin, PoseOrigin::kCarried);
  const auto moved = tracker.Update(At(160), Standing(3.05));
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->origin, PoseOrigin::kFound);
  EXPECT_EQ(moved->camera_from_world, Standing(3.05));
  // The same for a turn on the spot: a mirrored pose of a flat board does that.
  const auto turned = tracker.Update(At(200), LookAt({3.05, -2.0, 1.0}, {3.05 + 2.0, 0.0, 0.5}));
  EXPECT_EQ(turned->origin, PoseOrigin::kCarried);
}

TEST(PoseTracker, JumpsThatNothingConfirmsEndInALostCamera) {
  PoseTracker tracker;
  ASSERT_TRUE(tracker.Update(At(0), Standing(0.0)));
  for (int i = 1; i <= 3; ++i) {
    EXPECT_EQ(tracker.Update(At(40 * i), Standing(5.0 * i))->origin, PoseOrigin::kCarried) << i;
  }
  // No last pose to hold on to any more.
  EXPECT_EQ(tracker.Update(At(160), Standing(30.0))->origin, PoseOrigin::kFound);
}

// Minutes between frames: nothing to compare with, nothing to carry.
TEST(PoseTracker, FramesFarApartStandForThemselves) {
  PoseTracker tracker;
  ASSERT_TRUE(tracker.Update(At(0), Standing(0.0)));
  EXPECT_EQ(tracker.Update(At(600000), Standing(50.0))->origin, PoseOrigin::kFound);
  EXPECT_FALSE(tracker.Update(At(1200000), {}, "no marker is seen"));
  // The same backwards.
  EXPECT_EQ(tracker.Update(At(0), Standing(0.0))->origin, PoseOrigin::kFound);
}

TEST(PoseTracker, RefusesLimitsThatAreNone) {
  PoseTrackerOptions options;
  options.believable_speed_m_s = 0.0;
  EXPECT_THROW(PoseTracker{options}, std::invalid_argument);
  options = {};
  options.carry_s = std::nan("");
  EXPECT_THROW(PoseTracker{options}, std::invalid_argument);
}

// Detection, pose and tracker together on a stream: the camera moves along an arc, frames 5 and 6
// have no markers in view, 12 to 17 none either.
TEST(PoseTracker, FollowsACameraThroughAStreamOfPictures) {
  const MarkerBoard board = RoomBoard();
  CameraIntrinsics intrinsics = MarkerCamera();
  // Half the size, for speed.
  intrinsics.width_px = 320;
  intrinsics.height_px = 240;
  intrinsics.fx_px = intrinsics.fy_px = 300.0;
  intrinsics.cx_px = 160.0;
  intrinsics.cy_px = 119.0;
  const Lens lens(intrinsics);
  PoseTracker tracker;
  int found = 0;
  int carried = 0;
  int lost = 0;
  for (int i = 0; i < 22; ++i) {
    const glm::dmat4 truth =
        LookAt({1.5 * std::sin(0.03 * i), -1.5 * std::cos(0.03 * i), 1.1}, {0.05, 0.2, 0.1});
    const bool hidden = i == 5 || i == 6 || (i >= 12 && i <= 17);
    const Gray8Image picture =
        hidden ? Gray8Image(intrinsics.width_px, intrinsics.height_px, 90)
               : RenderMarkers(board, intrinsics, truth, 1.0, static_cast<unsigned>(i));
    const auto pose = FindBoardPose(
        lens, board, DetectMarkers(picture, board.dictionary), {}, tracker.Expected(At(40 * i)));
    const auto tracked = pose ? tracker.Update(At(40 * i), pose->pose.camera_from_world)
                              : tracker.Update(At(40 * i), std::nullopt, pose.error().reason);
    if (!tracked) {
      ++lost;
      EXPECT_GE(i, 15);
      EXPECT_THAT(tracked.error(), HasSubstr("camera pose is not known: no marker is seen"));
      continue;
    }
    EXPECT_EQ(tracked->origin == PoseOrigin::kCarried, hidden) << i;
    if (hidden) {
      ++carried;
      continue;
    }
    ++found;
    EXPECT_LT(glm::distance(CentreOfPose(tracked->camera_from_world), CentreOfPose(truth)), 0.01);
    EXPECT_LT(RotationBetweenRad(tracked->camera_from_world, truth), 0.005);
  }
  EXPECT_EQ(found, 14);
  EXPECT_EQ(carried, 5);
  EXPECT_EQ(lost, 3);
}

}  // namespace
}  // namespace pleinair::pose_tracker_test

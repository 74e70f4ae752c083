#include "calib/pose_track.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/calib/marker_scene.h"

namespace pleinair::pose_track_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

UtcTime At(int ms) { return UtcTime(std::chrono::sys_days{2026y / 6 / 21}) + ms * 1ms; }
glm::dmat4 Standing(double x) { return LookAt({x, -2.0, 1.0}, {x, 0.0, 0.5}); }
TimedPose Pose(int ms, double x) { return {At(ms), Standing(x)}; }
double XOf(const glm::dmat4& pose) { return CentreOfPose(pose).x; }

// At 1 m/s, a pose every 100 ms; frames between them are where the camera was.
TEST(PoseTrack, FramesAreMatchedByTheirTimes) {
  PoseTrack track;
  std::vector<int> times_ms;
  for (int ms = 0; ms <= 1000; ms += 100) times_ms.push_back(ms);
  // Late ones come after later ones.
  std::shuffle(times_ms.begin(), times_ms.end(), std::mt19937_64(5));
  for (const int ms : times_ms) track.Add(Pose(ms, 0.001 * ms));
  for (int ms = 0; ms <= 1000; ms += 7) {
    const auto pose = track.At(At(ms));
    ASSERT_TRUE(pose) << ms;
    EXPECT_NEAR(XOf(pose->camera_from_world), 0.001 * ms, 1e-12);
    EXPECT_EQ(pose->held_s, 0.0);
  }
  // A frame at a pose's own time has that pose, bit for bit.
  EXPECT_EQ(track.At(At(300))->camera_from_world, Standing(0.3));
  EXPECT_TRUE(track.Reaches(At(1000)));
  EXPECT_FALSE(track.Reaches(At(1001)));
}

TEST(PoseTrack, TheLastPoseIsHeldForAStatedTime) {
  PoseTrack track;
  EXPECT_EQ(track.At(At(0)).error(), "there is no pose yet");
  EXPECT_THROW(track.LatestTime(), std::logic_error);
  track.Add(Pose(0, 1.0));
  const auto held = track.At(At(150));
  ASSERT_TRUE(held);
  EXPECT_EQ(held->camera_from_world, Standing(1.0));
  EXPECT_NEAR(held->held_s, 0.15, 1e-12);
  EXPECT_TRUE(track.At(At(-200)));
  EXPECT_EQ(track.At(At(1000)).error(),
            "the last pose is 1.000 s older than the frame, expected at most 0.200 s");
  EXPECT_EQ(track.At(At(-201)).error(),
            "the first pose is 0.201 s later than the frame, expected at most 0.200 s");
}

// Poses missing for a second: what the camera did meanwhile is not known.
TEST(PoseTrack, AGapIsNotBridged) {
  PoseTrack track;
  track.Add(Pose(0, 0.0));
  track.Add(Pose(1000, 5.0));
  EXPECT_EQ(track.At(At(100))->camera_from_world, Standing(0.0));
  EXPECT_EQ(track.At(At(900))->camera_from_world, Standing(5.0));
  for (const int ms : {201, 500, 799}) {
    const auto pose = track.At(At(ms));
    ASSERT_FALSE(pose) << ms;
    EXPECT_EQ(pose.error(),
              "there is no pose for 1.000 s around the frame, expected at most 0.200 s");
  }
  // As large as may be.
  track.Add(Pose(800, 4.0));
  EXPECT_NEAR(XOf(track.At(At(900))->camera_from_world), 4.5, 1e-12);
}

// No time between two poses: the one that came last holds, whatever came between.
TEST(PoseTrack, OfOneTimeTheLastCallHolds) {
  PoseTrack track;
  track.Add(Pose(0, 0.0));
  track.Add(Pose(100, 1.0));
  track.Add(Pose(100, 2.0));
  EXPECT_EQ(track.At(At(100))->camera_from_world, Standing(2.0));
  EXPECT_NEAR(XOf(track.At(At(50))->camera_from_world), 1.0, 1e-12);
}

TEST(PoseTrack, KeepsTheLatest) {
  PoseTrack track({}, 10);
  for (int i = 0; i < 1000; ++i) track.Add(Pose(10 * i, 0.01 * i));
  EXPECT_FALSE(track.At(At(5000)));
  EXPECT_TRUE(track.At(At(9900)));
  // One that is older than all of them is not kept.
  track.Add(Pose(0, 7.0));
  EXPECT_FALSE(track.At(At(0)));
}

// Times at the ends of what is counted.
TEST(PoseTrack, TimesOfAllCenturies) {
  PoseTrack track;
  track.Add({UtcTime::min(), Standing(0.0)});
  track.Add({UtcTime::max(), Standing(1.0)});
  EXPECT_EQ(track.LatestTime(), UtcTime::max());
  EXPECT_TRUE(track.Reaches(UtcTime::max()));
  EXPECT_EQ(track.At(UtcTime::max())->camera_from_world, Standing(1.0));
  EXPECT_THAT(track.At(At(0)).error(), HasSubstr("there is no pose for 18446744073.710 s"));
}

TEST(PoseTrack, RefusesWhatIsNoPose) {
  PoseTrack track;
  glm::dmat4 mirrored = Standing(0.0);
  for (int c = 0; c < 4; ++c) mirrored[c][0] = -mirrored[c][0];
  glm::dmat4 scaled = Standing(0.0);
  scaled[0] *= 1.01;
  for (const auto& [bad, reason] : {std::pair{mirrored, "a rotation, not a mirror image"},
                                    std::pair{scaled, "a rigid transform"}}) {
    try {
      track.Add({At(0), bad});
      FAIL() << "accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(std::string("camera_from_world: expected ") + reason));
    }
  }
  EXPECT_TRUE(track.IsEmpty());
}

TEST(PoseTrack, RefusesLimitsThatAreNone) {
  EXPECT_THROW(PoseTrack({-0.1, 0.2}), std::invalid_argument);
  EXPECT_THROW(PoseTrack({0.1, std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::pose_track_test

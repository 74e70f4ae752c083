// Which picture a change of the camera's controls applies to.
#include <cstdint>

#include <gtest/gtest.h>

#include "datasets/camera/internal/camera_lock.h"

namespace pleinair::exposure_timeline_test {
namespace {

const CapturedExposure kShort{0.001, 1.0};
const CapturedExposure kLong{0.01, 1.0};
const CapturedExposure kLoud{0.01, 4.0};

TEST(ExposureTimeline, KnowsNothingBeforeTheFirstReading) {
  ExposureTimeline timeline(2);
  EXPECT_EQ(timeline.At(0), CapturedExposure{});
}

TEST(ExposureTimeline, TheFirstReadingHasBeenValidBefore) {
  ExposureTimeline timeline(2);
  timeline.Add(10, kShort);
  EXPECT_EQ(timeline.At(10), kShort);
  EXPECT_EQ(timeline.At(12), kShort);
}

TEST(ExposureTimeline, AChangeAppliesAfterTheCamerasDelay) {
  for (const int delay : {0, 1, 2, 5}) {
    ExposureTimeline timeline(delay);
    for (std::uint32_t picture = 0; picture < 20; ++picture) {
      timeline.Add(picture, picture < 8 ? kShort : kLong);
      const bool is_long = picture >= 8 + static_cast<std::uint32_t>(delay);
      EXPECT_EQ(timeline.At(picture), is_long ? kLong : kShort) << delay << ", " << picture;
    }
  }
}

// The automatics change it picture by picture: each change has its own delay.
TEST(ExposureTimeline, ChangesFollowEachOther) {
  ExposureTimeline timeline(3);
  timeline.Add(0, kShort);
  timeline.Add(4, kLong);
  timeline.Add(5, kLoud);
  EXPECT_EQ(timeline.At(6), kShort);
  EXPECT_EQ(timeline.At(7), kLong);
  EXPECT_EQ(timeline.At(8), kLoud);
  EXPECT_EQ(timeline.At(1000), kLoud);
}

TEST(ExposureTimeline, ThereAndBackWithinTheDelayIsSeen) {
  ExposureTimeline timeline(2);
  timeline.Add(0, kShort);
  timeline.Add(1, kLong);
  timeline.Add(2, kShort);
  EXPECT_EQ(timeline.At(2), kShort);
  EXPECT_EQ(timeline.At(3), kLong);
  EXPECT_EQ(timeline.At(4), kShort);
}

TEST(ExposureTimeline, PicturesThatWereLostAreJumpedOver) {
  ExposureTimeline timeline(1);
  timeline.Add(0, kShort);
  timeline.Add(3, kLong);
  timeline.Add(6, kLoud);
  EXPECT_EQ(timeline.At(2), kShort);
  EXPECT_EQ(timeline.At(50), kLoud);
}

}  // namespace
}  // namespace pleinair::exposure_timeline_test

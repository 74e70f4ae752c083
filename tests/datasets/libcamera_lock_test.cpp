// What no virtual camera has: exposure, gain and white balance through libcamera's lists.
#include "datasets/camera/internal/libcamera_lock.h"

#include <libcamera/control_ids.h>

#include <array>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pleinair::libcamera_lock_test {
namespace {

namespace controls = libcamera::controls;
using libcamera::ControlInfo;
using libcamera::ControlInfoMap;
using libcamera::ControlList;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kQueued = 4;

ControlInfoMap BoardCamera() {
  ControlInfoMap::Map known;
  known.emplace(&controls::AeEnable, ControlInfo(false, true, true));
  known.emplace(&controls::AwbEnable, ControlInfo(false, true, true));
  known.emplace(&controls::ExposureTime, ControlInfo(100, 100'000, 10'000));
  known.emplace(&controls::AnalogueGain, ControlInfo(1.0f, 16.0f, 1.0f));
  known.emplace(&controls::ColourGains, ControlInfo(0.0f, 32.0f, 1.0f));
  return {std::move(known), controls::controls};
}

ControlList Metadata(std::int32_t exposure_us, float gain, float red = 1.9f, float blue = 1.4f) {
  ControlList metadata(controls::controls);
  metadata.set(controls::ExposureTime, exposure_us);
  metadata.set(controls::AnalogueGain, gain);
  const std::array<float, 2> gains{red, blue};
  metadata.set(controls::ColourGains, libcamera::Span<const float, 2>(gains));
  return metadata;
}

TEST(LibcameraLock, ReadsExposureAndGainOfARequest) {
  ControlList metadata = Metadata(8333, 2.5f);
  EXPECT_EQ(ExposureOf(metadata).exposure_s, 8333e-6);
  EXPECT_EQ(ExposureOf(metadata).gain, 2.5);
  metadata.set(controls::DigitalGain, 1.25f);
  EXPECT_EQ(ExposureOf(metadata).gain, 3.125);
  EXPECT_EQ(ExposureOf(ControlList(controls::controls)), CapturedExposure{});
}

// libcamera states black levels of 16 bits, whatever the picture has.
TEST(LibcameraLock, ReadsTheDevelopmentOfRawPictures) {
  ControlList metadata = Metadata(8333, 1.0f);
  const std::array<std::int32_t, 4> levels{4096, 4096, 4160, 4032};
  metadata.set(controls::SensorBlackLevels, libcamera::Span<const std::int32_t, 4>(levels));
  const RawDevelopment development = DevelopmentOf(metadata, 10);
  EXPECT_EQ(development.black_level, 64.0);
  EXPECT_EQ(development.white_level, UsualDevelopment(10).white_level);
  EXPECT_FLOAT_EQ(static_cast<float>(development.white_balance_rgb.r), 1.9f);
  EXPECT_EQ(development.white_balance_rgb.g, 1.0);
  EXPECT_FLOAT_EQ(static_cast<float>(development.white_balance_rgb.b), 1.4f);
  const RawDevelopment unknown = DevelopmentOf(ControlList(controls::controls), 12);
  EXPECT_EQ(unknown.black_level, UsualDevelopment(12).black_level);
}

// Until its automatics have settled, and what they found applies, no picture is handed out.
TEST(LibcameraLock, LocksAtWhatTheAutomaticsFound) {
  const ControlInfoMap known = BoardCamera();
  LibcameraLock lock("camera", known, {}, kQueued);
  EXPECT_TRUE(lock.StartControls().empty());
  int held_back = 0;
  ControlList sent(controls::controls);
  while (sent.empty()) {
    EXPECT_FALSE(lock.Take(Metadata(5000 + 100 * held_back, 1.0f)));
    sent = lock.TakeControls();
    ASSERT_LT(++held_back, 100);
  }
  EXPECT_EQ(sent.get(controls::AeEnable), false);
  EXPECT_EQ(sent.get(controls::AwbEnable), false);
  EXPECT_EQ(sent.get(controls::ExposureTime), 5000 + 100 * (held_back - 1));
  EXPECT_EQ(sent.get(controls::AnalogueGain), 1.0f);
  EXPECT_EQ((*sent.get(controls::ColourGains))[0], 1.9f);
  const std::int32_t locked_us = *sent.get(controls::ExposureTime);
  const int delay = kQueued + CameraRequest().ControlDelayFrames();
  for (int i = 0; i < delay; ++i) EXPECT_FALSE(lock.Take(Metadata(locked_us + 50, 1.0f)));
  EXPECT_TRUE(lock.Take(Metadata(locked_us, 1.0f)));
  EXPECT_EQ(lock.Exposure().exposure_s, locked_us * 1e-6);
  EXPECT_TRUE(lock.TakeControls().empty());
  EXPECT_THAT(lock.TakeNotes(), IsEmpty());
}

// A camera that comes back is asked for what the lock has found.
TEST(LibcameraLock, NeedsNotSettleAgain) {
  const ControlInfoMap known = BoardCamera();
  LibcameraLock first("camera", known, {}, kQueued);
  EXPECT_EQ(first.Settings().exposure_s, std::nullopt);
  while (first.TakeControls().empty()) EXPECT_FALSE(first.Take(Metadata(5000, 2.0f)));
  EXPECT_EQ(first.Settings().exposure_s, 5000e-6);
  EXPECT_EQ(first.Settings().gain, 2.0);

  CameraRequest request;
  request.exposure_s = first.Settings().exposure_s;
  request.gain = first.Settings().gain;
  request.colour_gains = first.Settings().colour_gains;
  LibcameraLock second("camera", known, request, kQueued);
  const ControlList start = second.StartControls();
  EXPECT_EQ(start.get(controls::AeEnable), false);
  EXPECT_EQ(start.get(controls::AwbEnable), false);
  EXPECT_EQ(start.get(controls::ExposureTime), 5000);
  EXPECT_EQ(start.get(controls::AnalogueGain), 2.0f);
  EXPECT_EQ((*start.get(controls::ColourGains))[0], 1.9f);
  EXPECT_EQ((*start.get(controls::ColourGains))[1], 1.4f);
  for (int i = 0; i < request.ControlDelayFrames(); ++i) {
    EXPECT_FALSE(second.Take(Metadata(5000, 2.0f)));
  }
  EXPECT_TRUE(second.Take(Metadata(5000, 2.0f)));
  EXPECT_TRUE(second.TakeControls().empty());
  EXPECT_THAT(second.TakeNotes(), IsEmpty());
}

TEST(LibcameraLock, ReportsWhatDidNotTake) {
  ControlInfoMap::Map only;
  only.emplace(&controls::AeEnable, ControlInfo(false, true, true));
  only.emplace(&controls::ExposureTime, ControlInfo(100, 100'000, 10'000));
  only.emplace(&controls::AnalogueGain, ControlInfo(1.0f, 16.0f, 1.0f));
  const ControlInfoMap known(std::move(only), controls::controls);
  CameraRequest request;
  request.exposure_s = 0.5;
  request.gain = 32.0;
  LibcameraLock lock("camera", known, request, kQueued);
  const ControlList start = lock.StartControls();
  EXPECT_EQ(start.get(controls::AeEnable), false);
  EXPECT_EQ(start.get(controls::ExposureTime), 500'000);
  EXPECT_EQ(start.get(controls::AnalogueGain), 32.0f);
  for (int i = 0; i < request.ControlDelayFrames(); ++i) {
    EXPECT_FALSE(lock.Take(Metadata(100'000, 16.0f)));
  }
  EXPECT_TRUE(lock.Take(Metadata(100'000, 16.0f)));
  EXPECT_DOUBLE_EQ(*lock.Exposure().exposure_s, 0.1);  // What it is, not what was asked for.
  EXPECT_THAT(lock.TakeNotes(),
              ElementsAre("camera: exposure: expected 0.5 s, the camera set 0.1 s",
                          "camera: gain: expected 32, the camera set 16"));
  EXPECT_TRUE(lock.Take(Metadata(100'000, 16.0f)));
  EXPECT_THAT(lock.TakeNotes(), IsEmpty());
}

TEST(LibcameraLock, ReportsControlsThatAreMissing) {
  const ControlInfoMap known(ControlInfoMap::Map{}, controls::controls);
  CameraRequest request;
  request.exposure_s = 0.01;
  request.gain = 2.0;
  request.white_balance_k = 5000.0;
  request.control_delay_frames = 0;
  LibcameraLock lock("camera", known, request, kQueued);
  EXPECT_TRUE(lock.StartControls().empty());
  EXPECT_TRUE(lock.Take(ControlList(controls::controls)));
  EXPECT_EQ(lock.Exposure(), CapturedExposure{});
  EXPECT_THAT(lock.TakeNotes(),
              ElementsAre("camera: expected a control of exposure, the camera has none",
                          "camera: expected a control of gain, the camera has none",
                          HasSubstr("white balance"),
                          HasSubstr("states no exposure time")));
}

TEST(LibcameraLock, LeavesAutomaticsAloneWhereAskedTo) {
  const ControlInfoMap known = BoardCamera();
  CameraRequest request;
  request.automatic = true;
  LibcameraLock lock("camera", known, request, kQueued);
  EXPECT_TRUE(lock.StartControls().empty());
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(lock.Take(Metadata(5000 + i, 1.0f + static_cast<float>(i))));
    EXPECT_EQ(lock.Exposure().exposure_s, (5000 + i) * 1e-6);
    EXPECT_EQ(lock.Exposure().gain, 1.0 + i);
    EXPECT_TRUE(lock.TakeControls().empty());
  }
}

}  // namespace
}  // namespace pleinair::libcamera_lock_test

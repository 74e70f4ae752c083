// A camera as its driver has it, through pleinair's own code: the stand-in in the ordinary tests,
// the kernel's vivid and vimc in scripts/test-cameras.
//
// PLEINAIR_TEST_CAMERA          device, as OpenCamera takes it; without it all tests are skipped
// PLEINAIR_TEST_CAMERA_UNPLUG   shell command that unplugs it
// PLEINAIR_TEST_CAMERA_PLUG     shell command that plugs it in again

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "datasets/camera/camera.h"
#include "datasets/camera/camera_capture.h"
#include "datasets/camera/camera_clock.h"

namespace pleinair::camera_device_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr std::chrono::seconds kPatience{30};  // An emulated machine is slow.

std::string Given(const char* variable) {
  const char* value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

double SecondsSince(steady_clock::time_point start) {
  return std::chrono::duration<double>(steady_clock::now() - start).count();
}

// The next picture; a failure where there is none.
std::optional<CapturedBuffer> NextOf(CameraStream& camera) {
  const auto start = steady_clock::now();
  for (;;) {
    auto buffer = camera.Next(milliseconds(500));
    if (buffer) return std::move(*buffer);
    const CameraFaultKind fault = buffer.error().kind;
    const bool may_still_come =
        fault == CameraFaultKind::kStalled || fault == CameraFaultKind::kSettling;
    if (may_still_come && steady_clock::now() - start < kPatience) continue;
    ADD_FAILURE() << buffer.error().reason;
    return std::nullopt;
  }
}

// Mean codes or signals of a picture, and how much its pixels differ.
struct Colours {
  glm::dvec3 mean{0.0};
  double deviation = 0.0;
};

Colours ColoursOf(const CapturedBuffer& buffer) {
  Colours colours;
  std::vector<glm::dvec3> pixels;
  if (buffer.layout.format.coding == PixelCoding::kBayer) {
    const auto picture = Develop(buffer.bytes, buffer.layout, buffer.development.value());
    EXPECT_TRUE(picture) << picture.error();
    if (picture) {
      for (const glm::vec3& pixel : picture->signal_rgb.pixels) pixels.emplace_back(pixel);
    }
  } else {
    const auto picture = DecodeCodes(buffer.bytes, buffer.layout);
    EXPECT_TRUE(picture) << picture.error();
    if (picture) {
      for (const auto& pixel : picture->pixels) pixels.emplace_back(pixel);
    }
  }
  if (pixels.empty()) return colours;
  for (const glm::dvec3& pixel : pixels) colours.mean += pixel;
  colours.mean /= static_cast<double>(pixels.size());
  for (const glm::dvec3& pixel : pixels) {
    colours.deviation += std::abs(pixel.g - colours.mean.g);
  }
  colours.deviation /= static_cast<double>(pixels.size());
  return colours;
}

class CameraDevice : public testing::Test {
 protected:
  void SetUp() override {
    if (device_.empty()) GTEST_SKIP() << "PLEINAIR_TEST_CAMERA names no camera";
    for (const CameraDescription& camera : ListCameras().cameras) {
      if (camera.device == device_) description_ = camera;
    }
    ASSERT_EQ(description_.device, device_) << "not listed";
  }

  // The mode of this format that is closest to 640x480.
  CameraMode ModeOf(const PixelFormat& format) const {
    const CameraMode* best = nullptr;
    const auto cost = [](const CameraMode& mode) {
      return std::abs(mode.width_px - 640) + std::abs(mode.height_px - 480);
    };
    for (const CameraMode& mode : description_.modes) {
      if (mode.format == format && (best == nullptr || cost(mode) < cost(*best))) best = &mode;
    }
    return *best;
  }

  std::vector<PixelFormat> Formats() const {
    std::vector<PixelFormat> formats;
    for (const CameraMode& mode : description_.modes) {
      if (formats.empty() || !(formats.back() == mode.format)) formats.push_back(mode.format);
    }
    return formats;
  }

  static CameraRequest RequestOf(const CameraMode& mode) {
    CameraRequest request;
    request.format = mode.format;
    request.width_px = mode.width_px;
    request.height_px = mode.height_px;
    request.automatic = true;  // No pictures are spent to settle.
    return request;
  }

  std::optional<CameraControl> ControlNow(const std::string& name) const {
    for (const CameraDescription& camera : ListCameras().cameras) {
      if (camera.device != device_) continue;
      for (const CameraControl& control : camera.controls) {
        if (control.name == name) return control;
      }
    }
    return std::nullopt;
  }

  // Sets a control that the driver calls so, beside pleinair; false where there is none.
  bool SetByName(std::string_view name, int value) const {
    const int file = open(device_.c_str(), O_RDWR);
    if (file < 0) return false;
    v4l2_queryctrl query{};
    query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
    bool is_set = false;
    while (!is_set && ioctl(file, VIDIOC_QUERYCTRL, &query) == 0) {
      if (reinterpret_cast<const char*>(query.name) == name) {
        v4l2_control control{query.id, value};
        is_set = ioctl(file, VIDIOC_S_CTRL, &control) == 0;
      }
      query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
    }
    close(file);
    return is_set;
  }

  const std::string device_ = Given("PLEINAIR_TEST_CAMERA");
  CameraDescription description_;
};

TEST_F(CameraDevice, IsListedAndFoundByItsIdentity) {
  EXPECT_THAT(description_.identity, Not(IsEmpty()));
  EXPECT_THAT(description_.name, Not(IsEmpty()));
  EXPECT_THAT(description_.driver, Not(IsEmpty()));
  EXPECT_THAT(description_.modes, Not(IsEmpty()));
  EXPECT_EQ(FindCamera(description_.identity), device_);
  EXPECT_EQ(FindCamera(description_.identity + "?"), std::nullopt);
  for (const CameraControl& control : description_.controls) {
    EXPECT_LE(control.minimum, control.maximum) << control.name;
    EXPECT_GE(control.value, control.minimum) << control.name;
    EXPECT_LE(control.value, control.maximum) << control.name;
  }
}

TEST_F(CameraDevice, StreamsEachFormat) {
  constexpr int kPictures = 4;
  std::map<std::string, Colours> colours;
  for (const PixelFormat& format : Formats()) {
    SCOPED_TRACE(NameOf(format));
    const CameraMode mode = ModeOf(format);
    const auto start = steady_clock::now();
    const auto camera = OpenCamera(device_, RequestOf(mode));
    EXPECT_EQ(camera->Identity(), description_.identity);
    EXPECT_EQ(camera->Layout().format, format);
    EXPECT_EQ(camera->Layout().width_px, mode.width_px);
    EXPECT_EQ(camera->Layout().height_px, mode.height_px);
    std::optional<CapturedBuffer> last;
    double first_s = 0.0;
    for (int i = 0; i < kPictures; ++i) {
      std::optional<CapturedBuffer> buffer = NextOf(*camera);
      ASSERT_TRUE(buffer);
      if (i == 0) first_s = SecondsSince(start);
      EXPECT_FALSE(buffer->is_damaged);
      EXPECT_EQ(buffer->layout, camera->Layout());
      const double age_s =
          std::chrono::duration<double>(CameraClock().MonotonicNow() - buffer->monotonic_time)
              .count();
      EXPECT_GE(age_s, -0.1);  // vivid states the end of the frame, ahead of time.
      EXPECT_LE(age_s, 10.0);
      if (last) {
        EXPECT_GE(buffer->sequence, last->sequence);  // vivid repeats counts at 60 Hz.
        EXPECT_GT(buffer->monotonic_time, last->monotonic_time);
      }
      last = std::move(buffer);
    }
    const Colours found = ColoursOf(*last);
    EXPECT_GT(found.deviation, 0.0) << "a picture of one colour";
    colours[NameOf(format)] = found;
    std::printf("%s: %s %dx%d at %.4g Hz: first picture after %.2f s, mean %.2f %.2f %.2f\n",
                device_.c_str(),
                NameOf(format).c_str(),
                mode.width_px,
                mode.height_px,
                camera->FramesPerSecond(),
                first_s,
                found.mean.r,
                found.mean.g,
                found.mean.b);
  }
  // Both see one picture: their means differ by roundings, by colours that two pixels share (at
  // edges), by what YUV cannot hold, and by a counter that vivid and vimc draw.
  if (!colours.contains("RGB24")) return;
  for (const char* name : {"YUYV", "NV12", "MJPEG"}) {
    if (!colours.contains(name)) continue;
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(colours[name].mean[channel], colours["RGB24"].mean[channel], 2.0) << name;
    }
  }
}

TEST_F(CameraDevice, StreamsEachSize) {
  const PixelFormat format = Formats().front();
  int sizes = 0;
  for (const CameraMode& mode : description_.modes) {
    if (!(mode.format == format) || mode.width_px * mode.height_px > 1280 * 720) continue;
    SCOPED_TRACE(std::to_string(mode.width_px) + "x" + std::to_string(mode.height_px));
    const auto camera = OpenCamera(device_, RequestOf(mode));
    EXPECT_EQ(camera->Layout().width_px, mode.width_px);
    EXPECT_EQ(camera->Layout().height_px, mode.height_px);
    const std::optional<CapturedBuffer> buffer = NextOf(*camera);
    ASSERT_TRUE(buffer);
    EXPECT_GT(ColoursOf(*buffer).deviation, 0.0);
    ++sizes;
  }
  EXPECT_GT(sizes, 0);
}

TEST_F(CameraDevice, KeepsTheRateThatItStates) {
  const CameraMode mode = ModeOf(Formats().front());
  if (mode.frames_per_second.empty()) GTEST_SKIP() << "the driver lists no rates";
  CameraRequest request = RequestOf(mode);
  // The slowest one above 4 Hz: an emulated machine keeps up with it.
  request.frames_per_second = mode.frames_per_second.front();
  for (const double rate : mode.frames_per_second) {
    if (rate > 4.0) request.frames_per_second = rate;
  }
  const auto camera = OpenCamera(device_, request);
  EXPECT_NEAR(camera->FramesPerSecond(), *request.frames_per_second, 0.01);
  constexpr int kPictures = 8;
  std::optional<CapturedBuffer> first;
  std::optional<CapturedBuffer> last;
  for (int i = 0; i < kPictures; ++i) {
    last = NextOf(*camera);
    ASSERT_TRUE(last);
    if (!first) first = last;
  }
  ASSERT_TRUE(first->sequence && last->sequence);
  const double seconds =
      std::chrono::duration<double>(last->monotonic_time - first->monotonic_time).count();
  // Lost pictures are counted. A late first or last one is half an interval.
  EXPECT_NEAR(seconds * camera->FramesPerSecond(), *last->sequence - *first->sequence, 0.5);
}

TEST_F(CameraDevice, SetsTheGainThatIsAskedFor) {
  const std::optional<CameraControl> gain = ControlNow("Gain");
  if (!gain) GTEST_SKIP() << "the camera has no gain";
  CameraRequest request;
  request.gain = std::round((gain->minimum + gain->maximum) / 2.0);
  {
    const auto camera = OpenCamera(device_, request);
    ASSERT_TRUE(NextOf(*camera));
    EXPECT_EQ(ControlNow("Gain")->value, *request.gain);
    for (const std::string& note : camera->TakeNotes()) EXPECT_THAT(note, Not(HasSubstr("gain")));
  }
  request.gain = gain->maximum + 1.0;
  const auto camera = OpenCamera(device_, request);
  ASSERT_TRUE(NextOf(*camera));
  EXPECT_THAT(camera->TakeNotes(), testing::Contains(HasSubstr("gain: expected")));
  EXPECT_EQ(ControlNow("Gain")->value, gain->maximum);
}

TEST_F(CameraDevice, ReportsControlsThatItHasNot) {
  if (ControlNow("Exposure Time, Absolute") || ControlNow("ExposureTime")) {
    GTEST_SKIP() << "the camera has an exposure time";
  }
  CameraRequest request;
  request.exposure_s = 0.01;
  const auto camera = OpenCamera(device_, request);
  const std::optional<CapturedBuffer> buffer = NextOf(*camera);
  ASSERT_TRUE(buffer);
  EXPECT_EQ(buffer->exposure.exposure_s, std::nullopt);
  EXPECT_THAT(camera->TakeNotes(), testing::Contains(HasSubstr("exposure")));
}

TEST_F(CameraDevice, LocksWhatIsAutomatic) {
  const std::vector<std::string> automatics{
      "Auto Exposure", "Gain, Automatic", "White Balance, Automatic"};
  bool has_any = false;
  const auto camera = OpenCamera(device_, {});
  ASSERT_TRUE(NextOf(*camera));
  for (const std::string& name : automatics) {
    const std::optional<CameraControl> control = ControlNow(name);
    if (!control) continue;
    has_any = true;
    EXPECT_EQ(control->value, name == "Auto Exposure" ? V4L2_EXPOSURE_MANUAL : 0) << name;
  }
  if (!has_any) GTEST_SKIP() << "the camera has no automatic control";
}

// vivid hands buffers out that its driver says are damaged.
TEST_F(CameraDevice, ReportsDamagedBuffers) {
  const auto camera = OpenCamera(device_, RequestOf(ModeOf(Formats().front())));
  ASSERT_TRUE(NextOf(*camera));
  if (!SetByName("Inject V4L2_BUF_FLAG_ERROR", 1)) GTEST_SKIP() << "the driver injects no errors";
  int damaged = 0;
  for (int i = 0; i < 10; ++i) {
    const std::optional<CapturedBuffer> buffer = NextOf(*camera);
    ASSERT_TRUE(buffer);
    damaged += buffer->is_damaged ? 1 : 0;
  }
  EXPECT_EQ(damaged, 1);
}

void ExpectEvent(const EventLog& events, EventKind kind) {
  const auto start = steady_clock::now();
  while (events.CountOf(kind) == 0 && steady_clock::now() - start < kPatience) usleep(20'000);
  EXPECT_GT(events.CountOf(kind), 0) << NameOf(kind);
}

TEST_F(CameraDevice, ComesBackAfterUnplugging) {
  const std::string unplug = Given("PLEINAIR_TEST_CAMERA_UNPLUG");
  if (unplug.empty()) GTEST_SKIP() << "PLEINAIR_TEST_CAMERA_UNPLUG is not set";
  EventLog events;
  CameraCapture capture(device_, RequestOf(ModeOf(Formats().front())), {}, events);
  ASSERT_TRUE(capture.Next());
  ASSERT_EQ(std::system(unplug.c_str()), 0);
  ExpectEvent(events, EventKind::kUnplugged);
  ASSERT_EQ(std::system(Given("PLEINAIR_TEST_CAMERA_PLUG").c_str()), 0);
  const auto start = steady_clock::now();
  ExpectEvent(events, EventKind::kReconnected);
  std::printf("%s: back after %.2f s\n", device_.c_str(), SecondsSince(start));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(capture.Next());
}

// vivid's HDMI input gets another signal, as a video source that is switched.
TEST_F(CameraDevice, FollowsAChangeOfItsSource) {
  EventLog events;
  CameraCapture capture(device_, {}, {}, events);
  ASSERT_TRUE(capture.Next());
  const PictureLayout before = capture.Layout();
  // 720x576 at 50 Hz.
  if (!SetByName("DV Timings", 4)) GTEST_SKIP() << "the driver has no other source";
  ASSERT_TRUE(SetByName("DV Timings Signal Mode", 4));  // "Selected DV Timings"
  ExpectEvent(events, EventKind::kFormatChanged);
  ExpectEvent(events, EventKind::kReconnected);
  std::optional<CameraFrame> frame;
  const auto start = steady_clock::now();
  do {
    frame = capture.Next();
    ASSERT_TRUE(frame);
  } while (frame->buffer.layout == before && steady_clock::now() - start < kPatience);
  EXPECT_NE(frame->buffer.layout.height_px, before.height_px);
  EXPECT_GT(ColoursOf(frame->buffer).deviation, 0.0);
}

}  // namespace
}  // namespace pleinair::camera_device_test

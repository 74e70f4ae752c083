// A camera through its faults, with streams that are made up.
#include "datasets/camera/camera_capture.h"

#include <array>
#include <deque>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/datasets/made_pictures.h"

namespace pleinair::camera_capture_test {
namespace {

using std::chrono::milliseconds;

constexpr PixelFormat kGrey{PixelCoding::kGrey};

// What a stream gives, call by call.
enum class Step { kPicture, kUncounted, kLost, kSilence, kSettling, kUnplugged, kEnded };

struct Script {
  std::vector<Step> steps;  // Then the stream has ended.
  double frames_per_second = 30.0;
  CameraSettings settings;
};

std::vector<Step> Times(std::size_t count, Step step) { return std::vector<Step>(count, step); }

std::vector<Step> operator+(std::vector<Step> first, const std::vector<Step>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

// Silence takes no time here.
class ScriptedStream final : public CameraStream {
 public:
  explicit ScriptedStream(Script script)
      : script_(std::move(script)), layout_(made_pictures::Frame(kGrey, 8, 6, 0).buffer.layout) {}

  tl::expected<CapturedBuffer, CameraFault> Next(milliseconds) override {
    const Step step = next_ < script_.steps.size() ? script_.steps[next_++] : Step::kEnded;
    switch (step) {
      case Step::kLost:
        ++sequence_;
        return Next({});
      case Step::kPicture:
      case Step::kUncounted: {
        CapturedBuffer buffer = made_pictures::Frame(kGrey, 8, 6, sequence_++).buffer;
        if (step == Step::kUncounted) buffer.sequence.reset();
        buffer.monotonic_time = CameraClock().MonotonicNow();
        return buffer;
      }
      case Step::kSilence:
        return tl::unexpected(CameraFault{CameraFaultKind::kStalled, "silence"});
      case Step::kSettling:
        return tl::unexpected(CameraFault{CameraFaultKind::kSettling, "settling"});
      case Step::kUnplugged:
        return tl::unexpected(CameraFault{CameraFaultKind::kUnplugged, "gone"});
      case Step::kEnded:
        break;
    }
    return tl::unexpected(CameraFault{CameraFaultKind::kEnded, "ended"});
  }
  const PictureLayout& Layout() const override { return layout_; }
  double FramesPerSecond() const override { return script_.frames_per_second; }
  const std::string& Identity() const override { return identity_; }
  CameraSettings Settings() const override { return script_.settings; }
  std::vector<std::string> TakeNotes() override { return {}; }

 private:
  Script script_;
  PictureLayout layout_;
  std::string identity_ = "made up";
  std::size_t next_ = 0;
  int sequence_ = 0;
};

// A camera that is opened once for each script.
class ScriptedCamera {
 public:
  explicit ScriptedCamera(std::deque<Script> scripts) : scripts_(std::move(scripts)) {}

  // All its pictures.
  std::vector<CameraFrame> Run(CameraRequest request = {}) {
    CaptureOptions options;
    options.queue_frames = 1000;
    options.open = [this](const std::string&, const CameraRequest& asked) {
      if (scripts_.empty()) throw std::runtime_error("no script is left");
      requests.push_back(asked);
      opened.push_back(std::chrono::steady_clock::now());
      Script script = std::move(scripts_.front());
      scripts_.pop_front();
      return std::make_unique<ScriptedStream>(std::move(script));
    };
    options.find = [](const std::string&) { return std::optional<std::string>("/dev/video7"); };
    CameraCapture capture("/dev/video7", request, options, events);
    std::vector<CameraFrame> frames;
    while (std::optional<CameraFrame> frame = capture.Next()) frames.push_back(std::move(*frame));
    return frames;
  }

  EventLog events;
  std::vector<CameraRequest> requests;
  std::vector<std::chrono::steady_clock::time_point> opened;

 private:
  std::deque<Script> scripts_;
};

// At 1 Hz: nine calls of 0.1 s without a picture before each that is passed over.
TEST(CameraCapture, PicturesThatAreUsedToSettleAreNoStall) {
  std::vector<Step> steps;
  for (int picture = 0; picture < 15; ++picture) {
    steps = steps + Times(9, Step::kSilence) + Times(1, Step::kSettling);
  }
  ScriptedCamera camera({{steps + Times(3, Step::kPicture), 1.0, {}}});
  EXPECT_EQ(camera.Run().size(), 3u);
  EXPECT_EQ(camera.events.CountOf(EventKind::kStalled), 0);
  EXPECT_EQ(camera.requests.size(), 1u);
}

// As of a loopback device when a reader comes: the count of the first picture is lost, and later
// that of any picture when another program begins to read.
TEST(CameraCapture, PicturesThatTheDriverHasNotCountedAreNoLoss) {
  const std::vector<Step> late = Times(57, Step::kLost) + Times(1, Step::kUncounted);
  ScriptedCamera camera(
      {{late + Times(3, Step::kPicture) + Times(2, Step::kUncounted) + Times(3, Step::kPicture),
        30.0,
        {}}});
  EXPECT_EQ(camera.Run().size(), 9u);
  EXPECT_EQ(camera.events.CountOf(EventKind::kFrameLost), 0);

  ScriptedCamera losing(
      {{Times(2, Step::kPicture) + Times(1, Step::kUncounted) + Times(4, Step::kLost) +
            Times(2, Step::kPicture) + Times(1, Step::kLost) + Times(1, Step::kPicture),
        30.0,
        {}}});
  EXPECT_EQ(losing.Run().size(), 6u);
  EXPECT_EQ(losing.events.CountOf(EventKind::kFrameLost), 5);
}

TEST(CameraCapture, ASlowCameraIsNotStalledBeforeThreeIntervals) {
  struct Case {
    double frames_per_second;
    std::size_t silent_calls;
    int stalls;
    std::size_t openings;
  };
  // A call is 0.1 s.
  for (const Case& known : {Case{30.0, 19, 0, 1},
                            Case{30.0, 20, 1, 1},
                            Case{30.0, 99, 1, 1},
                            Case{30.0, 100, 1, 2},
                            Case{0.0, 100, 1, 2},
                            Case{0.05, 599, 0, 1},
                            Case{0.05, 600, 1, 1},
                            Case{0.05, 999, 1, 1},
                            Case{0.05, 1000, 1, 2}}) {
    const std::vector<Step> steps =
        Times(known.silent_calls, Step::kSilence) + Times(1, Step::kPicture);
    ScriptedCamera camera({{steps, known.frames_per_second, {}},
                           {Times(1, Step::kPicture), known.frames_per_second, {}}});
    EXPECT_EQ(camera.Run().size(), 1u);
    EXPECT_EQ(camera.events.CountOf(EventKind::kStalled), known.stalls)
        << known.frames_per_second << " Hz, " << known.silent_calls;
    EXPECT_EQ(camera.requests.size(), known.openings)
        << known.frames_per_second << " Hz, " << known.silent_calls;
  }
}

TEST(CameraCapture, ACameraThatComesBackIsAskedForWhatItWasLockedAtFirst) {
  const std::vector<Step> gone = Times(1, Step::kPicture) + Times(1, Step::kUnplugged);
  CameraRequest request;
  request.white_balance_k = 5000.0;
  constexpr std::array<double, 2> kGains{1.9, 1.4};
  constexpr std::array<double, 2> kOtherGains{1.8, 1.5};
  // The camera clamps what it is asked for: asked again, it may not.
  ScriptedCamera camera({{Times(1, Step::kUnplugged), 30.0, {}},  // Before it is locked.
                         {gone, 30.0, {0.01, 250.0, 4900.0, kGains}},
                         {gone, 30.0, {0.02, 100.0, 4900.0, kOtherGains}},
                         {Times(1, Step::kPicture), 30.0, {}}});
  EXPECT_EQ(camera.Run(request).size(), 3u);
  ASSERT_EQ(camera.requests.size(), 4u);
  EXPECT_FALSE(camera.requests[1].exposure_s);
  EXPECT_FALSE(camera.requests[1].gain);
  for (const std::size_t opening : {2, 3}) {
    const CameraRequest& asked = camera.requests[opening];
    EXPECT_EQ(asked.exposure_s, 0.01);
    EXPECT_EQ(asked.gain, 250.0);
    EXPECT_EQ(asked.reference_gain, 250.0);
    EXPECT_EQ(asked.white_balance_k, 5000.0);
    EXPECT_EQ(asked.colour_gains, kGains);
    EXPECT_NO_THROW(asked.Validate());
  }
}

TEST(CameraCapture, AnAutomaticCameraThatComesBackKeepsItsReferenceAlone) {
  CameraRequest request;
  request.automatic = true;
  ScriptedCamera camera({{Times(1, Step::kUnplugged), 30.0, {0.01, 250.0, 4900.0, {}}}, {}});
  camera.Run(request);
  ASSERT_EQ(camera.requests.size(), 2u);
  EXPECT_EQ(camera.requests[1].reference_gain, 250.0);
  EXPECT_NO_THROW(camera.requests[1].Validate());
}

// It can be opened, and fails before its first picture.
TEST(CameraCapture, ACameraThatFailsAtOnceIsOpenedLessAndLessOften) {
  const Script fails{Times(1, Step::kUnplugged), 30.0, {}};
  ScriptedCamera camera({fails, fails, fails, fails, {Times(1, Step::kPicture), 30.0, {}}});
  EXPECT_EQ(camera.Run().size(), 1u);
  ASSERT_EQ(camera.opened.size(), 5u);
  // At once, then after 0.1, 0.2 and 0.4 s: sleeps are never shorter.
  for (std::size_t i = 2; i < camera.opened.size(); ++i) {
    EXPECT_GE(camera.opened[i] - camera.opened[i - 1], milliseconds(50) * (1 << (i - 1)));
  }
}

}  // namespace
}  // namespace pleinair::camera_capture_test

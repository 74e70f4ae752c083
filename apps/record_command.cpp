#include "apps/record_command.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "apps/camera_watch.h"
#include "apps/log_event.h"
#include "apps/stop_signals.h"
#include "datasets/camera/camera_capture.h"
#include "datasets/sequence.h"
#include "scene/elapsed.h"

namespace pleinair {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::seconds kTerminalProgress{1};
constexpr std::chrono::seconds kLoggedProgress{10};

std::string SizeText(std::uint64_t bytes) {
  constexpr double kGigabyte = 1e9;
  const auto size = static_cast<double>(bytes);
  return size < kGigabyte ? fmt::format("{:.0f} MB", size / 1e6)
                          : fmt::format("{:.1f} GB", size / kGigabyte);
}

std::string ProgressText(const RecorderStatus& status, const EventLog& events, double seconds) {
  return fmt::format(
      "{} pictures, {:.1f} a second, {} dropped, {} lost by the driver, {} damaged, "
      "{} written, {} free",
      status.written,
      static_cast<double>(status.written) / std::max(seconds, 1e-3),
      events.CountOf(EventKind::kFrameDropped),
      events.CountOf(EventKind::kFrameLost),
      status.damaged,
      SizeText(status.bytes),
      SizeText(status.free_bytes));
}

// A line that replaces itself on a terminal, and is logged now and then elsewhere.
class ProgressLine {
 public:
  ~ProgressLine() { Clear(); }

  // Before another line is written.
  void Clear() const {
    if (is_terminal_) std::fputs("\r\033[K", stderr);
  }

  void Show(const RecorderStatus& status, const EventLog& events) {
    if (SteadyClock::now() - shown_ < (is_terminal_ ? kTerminalProgress : kLoggedProgress)) return;
    shown_ = SteadyClock::now();
    const std::string text = ProgressText(status, events, SecondsSince(started_));
    if (is_terminal_) {
      std::fprintf(stderr, "\r\033[K%s", text.c_str());
      std::fflush(stderr);
    } else {
      spdlog::info("{}", text);
    }
  }

 private:
  const SteadyClock::time_point started_ = SteadyClock::now();
  SteadyClock::time_point shown_ = started_;
  const bool is_terminal_ = isatty(STDERR_FILENO) == 1;
};

void Record(const RecordCommandOptions& options, CameraCapture& capture, Recorder& recorder) {
  std::optional<std::chrono::nanoseconds> first;
  int recorded = 0;
  while (std::optional<CameraFrame> frame = capture.Next()) {
    const std::chrono::nanoseconds time = frame->buffer.monotonic_time;
    if (!first) first = time;
    const double seconds = std::chrono::duration<double>(time - *first).count();
    if (options.duration_s && seconds >= *options.duration_s) return;
    if (recorder.Offer(std::move(*frame))) ++recorded;
    if (recorded == options.frames_limit) return;
  }
}

// The number of pictures to come, where it is known.
std::optional<double> ExpectedPictures(const RecordCommandOptions& options,
                                       const CameraCapture& capture) {
  constexpr double kUsualRate = 30.0;
  std::optional<double> pictures;
  if (options.duration_s) {
    const double interval_s = std::chrono::duration<double>(options.recorder.interval).count();
    const double rate = capture.FramesPerSecond() > 0.0 ? capture.FramesPerSecond() : kUsualRate;
    pictures = *options.duration_s * (interval_s > 0.0 ? std::min(1.0 / interval_s, rate) : rate);
  }
  if (options.frames_limit) {
    pictures = std::min(pictures.value_or(*options.frames_limit), double(*options.frames_limit));
  }
  return pictures;
}

// Drivers give the size next to the one that they are asked for.
void RequireSize(const CameraRequest& asked, const PictureLayout& given) {
  if (!asked.width_px || (asked.width_px == given.width_px && asked.height_px == given.height_px)) {
    return;
  }
  throw std::runtime_error(
      fmt::format("--size {}x{}: expected a size that the camera has, such as {}x{}",
                  *asked.width_px,
                  asked.height_px.value_or(0),
                  given.width_px,
                  given.height_px));
}

std::string DeviceOf(const Sequence& site) {
  if (site.camera_device.empty()) {
    throw std::runtime_error(site.file.string() +
                             ": camera_device: expected a device or a camera's identity, as "
                             "nothing else says which camera to record (or DEVICE --site)");
  }
  if (IsCameraName(site.camera_device)) return site.camera_device;
  if (auto device = FindCamera(site.camera_device)) return *device;
  throw std::runtime_error(site.file.string() + ": camera_device: expected the camera '" +
                           site.camera_device + "', which is not plugged in");
}

}  // namespace

int RunRecordCommand(const RecordCommandOptions& options) {
  const UtcTime now = std::chrono::system_clock::now();
  const Sequence site = ReadSite(options.site, now);
  CameraRequest request = options.request;
  if (!request.width_px) {
    request.width_px = site.intrinsics.width_px;
    request.height_px = site.intrinsics.height_px;
  }
  StopSignals signals;
  EventLog events;
  CaptureOptions waiting;
  // A second's pictures: until the recorder has copied the site, and where its thread has to wait
  // for a processor.
  waiting.queue_frames = 30;
  CameraCapture capture(
      options.camera.empty() ? DeviceOf(site) : options.camera, request, waiting, events);
  RequireSize(options.request, capture.Layout());
  RecorderOptions recorder_options = options.recorder;
  recorder_options.recording.expected_pictures = ExpectedPictures(options, capture);
  Recorder recorder(site, capture.Layout(), recorder_options, events);
  const SteadyClock::time_point started = SteadyClock::now();
  double seconds = 0.0;
  {
    ProgressLine progress;
    WatchTasks tasks;
    tasks.write = [&](Event event) {
      // The program's last line says how it ended, and why.
      if (event.kind != EventKind::kEnded && event.kind != EventKind::kDisk) {
        progress.Clear();
        LogEvent(event);
      }
      recorder.AddEvents({std::move(event)});
    };
    tasks.look = [&] {
      const RecorderStatus status = recorder.Status();
      progress.Show(status, events);
      return !status.stopped.empty();
    };
    CameraWatch watch(signals, capture, events, options.duration_s, std::move(tasks));
    watch.StartTime();
    Record(options, capture, recorder);
    capture.Stop();
    seconds = SecondsSince(started);
    recorder.Close();
    watch.Finish(fmt::format("{} pictures recorded", recorder.Status().written));
  }
  recorder.Finish();
  const RecorderStatus status = recorder.Status();
  spdlog::info(
      "{}: {}", options.recorder.recording.folder.string(), ProgressText(status, events, seconds));
  if (status.stopped.empty() && status.written > 0) return 0;
  spdlog::error("{}", status.stopped.empty() ? "no picture was recorded" : status.stopped);
  return 1;
}

}  // namespace pleinair

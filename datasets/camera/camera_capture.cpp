#include "datasets/camera/camera_capture.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>

namespace pleinair {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

// Interval of checks for Stop, and for a camera that is back.
constexpr milliseconds kTick{100};
// Between attempts to open a camera, at most: each may try 256 devices.
constexpr milliseconds kLongestWait{1000};
// Drivers stamp a picture before it is handed over, and none that is older than this.
constexpr std::chrono::seconds kOldestPicture{10};
// A driver that computes the time of a frame's end may state it before that.
constexpr milliseconds kMostAhead{100};

double Seconds(nanoseconds duration) { return std::chrono::duration<double>(duration).count(); }

EventKind EventOf(CameraFaultKind fault) {
  switch (fault) {
    case CameraFaultKind::kEnded:
      return EventKind::kEnded;
    case CameraFaultKind::kStalled:
      return EventKind::kStalled;
    case CameraFaultKind::kFormatChanged:
      return EventKind::kFormatChanged;
    case CameraFaultKind::kUnplugged:
    case CameraFaultKind::kSettling:
    case CameraFaultKind::kFailed:
      break;
  }
  return EventKind::kUnplugged;
}

CaptureOptions WithCameras(CaptureOptions options) {
  if (!options.open) options.open = OpenCamera;
  if (!options.find) options.find = FindCamera;
  return options;
}

}  // namespace

CameraCapture::CameraCapture(const std::string& device,
                             CameraRequest request,
                             const CaptureOptions& options,
                             EventLog& events)
    : device_(device),
      request_(request),
      options_(WithCameras(options)),
      events_(events),
      stream_(options_.open(device, request_)),
      clock_(options.clock),
      layout_(stream_->Layout()),
      frames_per_second_(stream_->FramesPerSecond()),
      identity_(stream_->Identity()),
      queue_(options.queue_frames) {
  Note(EventKind::kStarted,
       fmt::format("{}: {} {}x{}, {:g} frames a second",
                   device_,
                   NameOf(layout_.format),
                   layout_.width_px,
                   layout_.height_px,
                   frames_per_second_));
  NoteControls();
  if (std::string warning = ClockWarning(); !warning.empty()) {
    Note(EventKind::kClock, std::move(warning));
  }
  // The request for a camera that comes back is its earlier mode.
  request_.format = layout_.format;
  request_.width_px = layout_.width_px;
  request_.height_px = layout_.height_px;
  if (frames_per_second_ > 0.0) request_.frames_per_second = frames_per_second_;
  thread_ = std::thread([this] { Run(); });
}

CameraCapture::~CameraCapture() {
  Stop();
  thread_.join();
}

std::optional<CameraFrame> CameraCapture::Next() { return stop_ ? std::nullopt : queue_.Pop(); }

void CameraCapture::Stop() {
  stop_ = true;
  queue_.Close();
}

void CameraCapture::Run() {
  milliseconds waited{0};
  while (!stop_) {
    auto buffer = stream_->Next(kTick);
    NoteControls();
    if (buffer) {
      waited = milliseconds{0};
      Take(std::move(*buffer));
      continue;
    }
    const CameraFault& fault = buffer.error();
    if (fault.kind == CameraFaultKind::kSettling) {
      waited = milliseconds{0};
      reopen_wait_ = milliseconds{0};
      continue;
    }
    if (fault.kind == CameraFaultKind::kStalled) {
      waited += kTick;
      NoteStall(waited);
      if (waited < Limit(options_.reopen, 5)) continue;
      Note(EventKind::kUnplugged, device_ + ": opened again, as it gives no pictures");
    } else {
      Note(EventOf(fault.kind), fault.reason);
    }
    if (fault.kind == CameraFaultKind::kEnded) break;
    waited = milliseconds{0};
    Reconnect();
  }
  queue_.Close();
}

milliseconds CameraCapture::Limit(milliseconds least, int intervals) const {
  const double rate = stream_->FramesPerSecond();
  if (!(rate > 0.0)) return least;
  return std::max(least, milliseconds(std::llround(std::min(1e3 * intervals / rate, 1e9))));
}

void CameraCapture::NoteStall(milliseconds waited) {
  if (is_stalled_ || waited < Limit(options_.stall, 3)) return;
  is_stalled_ = true;
  Note(EventKind::kStalled, fmt::format("{}: no picture for {:.1f} s", device_, Seconds(waited)));
}

void CameraCapture::KeepSettings() {
  const CameraSettings found = stream_->Settings();
  const auto keep = [](const auto& value, auto& asked) {
    if (!asked) asked = value;
  };
  keep(found.gain, request_.reference_gain);
  if (request_.automatic) return;
  keep(found.exposure_s, request_.exposure_s);
  keep(found.gain, request_.gain);
  keep(found.white_balance_k, request_.white_balance_k);
  keep(found.colour_gains, request_.colour_gains);
}

void CameraCapture::Reconnect() {
  KeepSettings();
  stream_.reset();
  std::string last_reason;
  while (WaitToReopen()) {
    if (const std::optional<std::string> device = options_.find(identity_)) {
      try {
        stream_ = options_.open(*device, request_);
        device_ = *device;
        last_sequence_.reset();
        Note(EventKind::kReconnected,
             fmt::format("{}: {} {}x{}",
                         device_,
                         NameOf(stream_->Layout().format),
                         stream_->Layout().width_px,
                         stream_->Layout().height_px));
        NoteControls();
        return;
      } catch (const std::exception& error) {
        // Also a camera that is being unplugged again.
        if (last_reason != error.what()) Note(EventKind::kUnplugged, error.what());
        last_reason = error.what();
      }
    }
  }
}

bool CameraCapture::WaitToReopen() {
  for (milliseconds slept{0}; slept < reopen_wait_ && !stop_; slept += kTick) {
    std::this_thread::sleep_for(kTick);
  }
  reopen_wait_ = std::clamp(2 * reopen_wait_, kTick, kLongestWait);
  return !stop_;
}

void CameraCapture::Take(CapturedBuffer buffer) {
  if (std::exchange(is_stalled_, false)) {
    Note(EventKind::kReconnected, device_ + ": gives pictures again");
  }
  if (last_sequence_) {
    const std::uint32_t next = *last_sequence_ + 1;  // Counts wrap around.
    const std::uint32_t sequence = buffer.sequence.value_or(next);
    const std::uint32_t lost = sequence - next;
    if (lost > 0 && lost < 0x7fffffffu) {
      Note(EventKind::kFrameLost, device_ + ": lost by the driver", lost);
    }
    last_sequence_ = sequence;
  } else {
    last_sequence_ = buffer.sequence;
  }
  reopen_wait_ = milliseconds{0};

  const nanoseconds now = clock_.MonotonicNow();
  nanoseconds taken = buffer.monotonic_time;
  if (taken > now && taken - now <= kMostAhead) taken = now;
  if (!(taken > last_time_) || taken > now || now - taken > kOldestPicture) {
    Note(EventKind::kTimestamp,
         fmt::format("{}: a picture's time is {:.3f} s {} the one before's, and {:.3f} s {} now: "
                     "replaced by its arrival",
                     device_,
                     std::abs(Seconds(taken - last_time_)),
                     taken > last_time_ ? "after" : "before",
                     std::abs(Seconds(now - taken)),
                     taken > now ? "after" : "before"));
    taken = std::max(now, last_time_ + nanoseconds{1});
  }
  last_time_ = taken;
  buffer.monotonic_time = taken;

  const CameraClock::Time time = clock_.UtcOf(taken);
  if (time.step) {
    Note(EventKind::kClock,
         fmt::format("the system's clock was stepped by {:+.3f} s: the pictures' UTC follows it",
                     Seconds(*time.step)));
  }
  if (queue_.PushOverOldest({std::move(buffer), time.utc})) {
    Note(EventKind::kFrameDropped, "dropped: a later picture was there already");
  }
}

void CameraCapture::NoteControls() {
  for (std::string& note : stream_->TakeNotes()) Note(EventKind::kControl, std::move(note));
}

void CameraCapture::Note(EventKind kind, std::string text, std::int64_t count) {
  events_.Add({clock_.Now(), kind, std::move(text), count});
}

}  // namespace pleinair

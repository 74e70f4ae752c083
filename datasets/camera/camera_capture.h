// Captures a camera's pictures on a thread of its own, and recovers from the camera's faults.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include <glm/mat4x4.hpp>

#include "datasets/camera/camera.h"
#include "datasets/camera/camera_clock.h"
#include "datasets/camera/frame_queue.h"
#include "datasets/event.h"
#include "scene/utc_time.h"

namespace pleinair {

// A picture as the driver delivered it, with its time. The monotonic time ascends: where the
// driver's does not, it is the time of arrival.
struct CameraFrame {
  CapturedBuffer buffer;
  UtcTime time{};
  // For a camera that moves, for its recording; none: the site's.
  std::optional<glm::dmat4> camera_from_world{};
};

// Set-up of CameraCapture.
struct CaptureOptions {
  std::size_t queue_frames = 2;           // The most pictures that wait for the consumer.
  std::chrono::milliseconds stall{2000};  // Time without a picture, and 3 intervals: an event.
  // Time without a picture, and 5 intervals: the camera is closed and opened again.
  std::chrono::milliseconds reopen{10000};
  CameraClock::Read clock;  // None: the system's.
  // None: OpenCamera and FindCamera.
  std::function<std::unique_ptr<CameraStream>(const std::string& device, const CameraRequest&)>
      open;
  std::function<std::optional<std::string>(const std::string& identity)> find;
};

// Never waits for its consumer: a full queue loses its oldest picture, which is counted. A camera
// that is unplugged, fails or changes its format is found by its identity and opened again with the
// first request. It is locked at once at the values of the first lock. Each fault is an event.
// Times ascend except where the system's clock is stepped back.
class CameraCapture {
 public:
  // Opens the camera. Throws as OpenCamera. `events` outlives it.
  CameraCapture(const std::string& device,
                CameraRequest request,
                const CaptureOptions& options,
                EventLog& events);
  ~CameraCapture();
  CameraCapture(const CameraCapture&) = delete;
  CameraCapture& operator=(const CameraCapture&) = delete;

  // Waits for a picture. None when the stream has ended, or after Stop.
  std::optional<CameraFrame> Next();
  // From any thread; pictures in the queue are lost.
  void Stop();

  // The first mode.
  const PictureLayout& Layout() const { return layout_; }
  double FramesPerSecond() const { return frames_per_second_; }  // 0: not stated.
  const CameraClock& Clock() const { return clock_; }

 private:
  void Run();
  // The request for a camera that comes back: the values of the first lock.
  void KeepSettings();
  // Until the camera is back, or Stop.
  void Reconnect();
  // Longer from attempt to attempt, until there is a picture. False after Stop.
  bool WaitToReopen();
  void Take(CapturedBuffer buffer);
  // At least `least`, and at least so many intervals of pictures.
  std::chrono::milliseconds Limit(std::chrono::milliseconds least, int intervals) const;
  // No picture for `waited`.
  void NoteStall(std::chrono::milliseconds waited);
  void NoteControls();
  void Note(EventKind kind, std::string text, std::int64_t count = 1);

  std::string device_;
  CameraRequest request_;
  CaptureOptions options_;
  EventLog& events_;
  std::unique_ptr<CameraStream> stream_;
  CameraClock clock_;
  PictureLayout layout_;
  double frames_per_second_ = 0.0;
  std::string identity_;
  std::optional<std::uint32_t> last_sequence_;
  std::chrono::nanoseconds last_time_{0};
  bool is_stalled_ = false;
  std::chrono::milliseconds reopen_wait_{0};
  FrameQueue<CameraFrame> queue_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace pleinair

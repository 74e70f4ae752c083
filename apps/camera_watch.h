// Watches a camera's run beside its pictures: events, and reasons to end.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "apps/stop_signals.h"
#include "datasets/camera/camera_capture.h"
#include "datasets/event.h"

namespace pleinair {

// Called by the watch's thread.
struct WatchTasks {
  std::function<void(Event)> write;  // Each event, in order; the last ones by Finish.
  // Called several times a second. Returns whether there is a reason to end.
  std::function<bool()> look = [] { return false; };
  std::function<void()> end = [] {};  // Called when the capture is stopped, perhaps repeatedly.
};

// SIGINT and SIGTERM, the time that was asked for and `look` stop the capture.
class CameraWatch {
 public:
  // All but `tasks` outlive it. `duration_s`: none is without end.
  CameraWatch(StopSignals& signals,
              CameraCapture& capture,
              EventLog& events,
              std::optional<double> duration_s,
              WatchTasks tasks);
  ~CameraWatch();
  CameraWatch(const CameraWatch&) = delete;
  CameraWatch& operator=(const CameraWatch&) = delete;

  // The duration counts from now on. Pictures themselves end a run in time; without any, it ends a
  // second later.
  void StartTime() { started_ = std::chrono::steady_clock::now(); }

  // Writes the last events, too. The run's end is the last of all.
  void Finish(std::string how_it_ended);

 private:
  void Run();
  bool IsTimeUp() const;

  StopSignals& signals_;
  CameraCapture& capture_;
  EventLog& events_;
  std::optional<double> duration_s_;
  WatchTasks tasks_;
  std::atomic<std::chrono::steady_clock::time_point> started_{};
  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

}  // namespace pleinair

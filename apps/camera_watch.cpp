#include "apps/camera_watch.h"

#include <utility>

#include <spdlog/spdlog.h>

namespace pleinair {

CameraWatch::CameraWatch(StopSignals& signals,
                         CameraCapture& capture,
                         EventLog& events,
                         std::optional<double> duration_s,
                         WatchTasks tasks)
    : signals_(signals),
      capture_(capture),
      events_(events),
      duration_s_(duration_s),
      tasks_(std::move(tasks)),
      thread_([this] { Run(); }) {}

CameraWatch::~CameraWatch() {
  is_over_ = true;
  if (thread_.joinable()) thread_.join();
}

void CameraWatch::Finish(std::string how_it_ended) {
  is_over_ = true;
  thread_.join();
  events_.Add({capture_.Clock().Now(), EventKind::kEnded, std::move(how_it_ended)});
  for (Event& event : events_.TakeAll()) tasks_.write(std::move(event));
}

void CameraWatch::Run() {
  constexpr std::chrono::milliseconds kTick{200};
  while (!is_over_) {
    const bool is_signalled = signals_.Wait(kTick);
    for (Event& event : events_.Take(capture_.Clock().Now())) tasks_.write(std::move(event));
    if (is_signalled) spdlog::info("ending; a second signal ends at once");
    const bool is_to_end = tasks_.look();
    // Goes on: for that second signal.
    if (is_to_end || is_signalled || IsTimeUp()) {
      capture_.Stop();
      tasks_.end();
    }
  }
}

bool CameraWatch::IsTimeUp() const {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = started_;
  return start != Clock::time_point() && duration_s_ &&
         std::chrono::duration<double>(Clock::now() - start).count() > *duration_s_ + 1.0;
}

}  // namespace pleinair

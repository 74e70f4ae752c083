#include "datasets/recording/recorder.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace pleinair {
namespace {

// In pictures of decoded codes, the largest form of a picture.
std::size_t QueueCapacity(const PictureLayout& layout, std::uint64_t bytes) {
  const std::uint64_t picture = 3ull * static_cast<std::uint64_t>(layout.width_px) *
                                static_cast<std::uint64_t>(layout.height_px);
  return std::clamp<std::uint64_t>(bytes / std::max<std::uint64_t>(picture, 1), 2, 300);
}

}  // namespace

Recorder::Recorder(const Sequence& site,
                   const PictureLayout& layout,
                   const RecorderOptions& options,
                   EventLog& events)
    : options_(options),
      events_(events),
      recording_(site, layout, options.recording),
      queue_(QueueCapacity(layout, options.queue_bytes)) {
  status_.free_bytes = recording_.FreeBytes();
  writer_ = std::thread([this] { Write(); });
  try {
    syncer_ = std::thread([this] { KeepSynced(); });
  } catch (...) {
    queue_.Close();
    writer_.join();
    throw;
  }
}

Recorder::~Recorder() { Finish(); }

bool Recorder::Offer(CameraFrame frame) {
  const std::chrono::nanoseconds now = frame.buffer.monotonic_time;
  if (next_due_ && now < *next_due_ && now >= *next_due_ - options_.interval) return false;
  const UtcTime time = frame.time;
  {
    const std::lock_guard lock(mutex_);
    if (is_closed_ || !status_.stopped.empty()) return false;
  }
  if (options_.interval.count() > 0) {
    // The grid of the first picture's time is kept, unless a picture comes too late for it.
    next_due_ = next_due_ && now - *next_due_ < options_.interval ? *next_due_ + options_.interval
                                                                  : now + options_.interval;
  }
  if (queue_.PushOverOldest(std::move(frame))) {
    events_.Add({time, EventKind::kFrameDropped, "not recorded: the disk is too slow"});
    const std::lock_guard lock(mutex_);
    ++status_.dropped;
  }
  return true;
}

void Recorder::AddEvents(std::vector<Event> events) {
  const std::lock_guard lock(mutex_);
  std::ranges::move(events, std::back_inserter(new_events_));
}

RecorderStatus Recorder::Status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

void Recorder::Close() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(is_closed_, true)) return;
  }
  queue_.Close();
  closed_.notify_all();
  writer_.join();
  syncer_.join();
}

void Recorder::Finish() {
  Close();
  if (std::exchange(is_finished_, true)) return;
  WriteEvents();
  Guard([this] { recording_.Finish(); });
  Sync();
}

void Recorder::Write() {
  while (const std::optional<CameraFrame> frame = queue_.Pop()) {
    if (Status().stopped.empty()) WriteOne(*frame);
    WriteEvents();
  }
}

void Recorder::WriteOne(const CameraFrame& frame) {
  Guard([&] {
    const auto bytes = recording_.Add(frame);
    if (!bytes) {
      events_.Add({frame.time, EventKind::kFrameDamaged, "not recorded: " + bytes.error()});
    }
    const std::uint64_t free_bytes = recording_.FreeBytes();
    const std::lock_guard lock(mutex_);
    ++(bytes ? status_.written : status_.damaged);
    status_.bytes += bytes.value_or(0);
    status_.free_bytes = free_bytes;
  });
}

void Recorder::WriteEvents() {
  std::vector<Event> events;
  {
    const std::lock_guard lock(mutex_);
    events.swap(new_events_);
  }
  if (!events.empty()) Guard([&] { recording_.AddEvents(events); });
}

void Recorder::KeepSynced() {
  std::unique_lock lock(mutex_);
  while (!closed_.wait_for(lock, options_.sync_interval, [this] { return is_closed_; })) {
    lock.unlock();
    Sync();
    lock.lock();
  }
}

void Recorder::Sync() {
  const std::int64_t written = Status().written;
  if (!Guard([this] { recording_.Sync(); })) return;
  const std::lock_guard lock(mutex_);
  status_.finished = written;
}

bool Recorder::Guard(const std::function<void()>& step) {
  try {
    step();
    return true;
  } catch (const std::exception& error) {
    {
      const std::lock_guard lock(mutex_);
      if (!status_.stopped.empty()) return false;
      status_.stopped = std::string("the recording ends: ") + error.what();
    }
    events_.Add({std::chrono::system_clock::now(), EventKind::kDisk, error.what()});
    return false;
  }
}

}  // namespace pleinair

#include "datasets/event.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <utility>

namespace pleinair {
namespace {

// Losses come frame by frame for as long as a machine is too slow: one line a second.
constexpr std::chrono::seconds kSummedOver{1};

bool IsSummed(EventKind kind) {
  return kind == EventKind::kFrameDropped || kind == EventKind::kFrameLost ||
         kind == EventKind::kFrameDamaged || kind == EventKind::kTimestamp ||
         kind == EventKind::kPose;
}

}  // namespace

std::string_view NameOf(EventKind kind) {
  constexpr std::array<std::string_view, kEventKinds> kNames = {"started",
                                                                "preparing",
                                                                "prepared",
                                                                "control",
                                                                "clock",
                                                                "frame-dropped",
                                                                "frame-lost",
                                                                "frame-damaged",
                                                                "timestamp",
                                                                "stalled",
                                                                "unplugged",
                                                                "format-changed",
                                                                "reconnected",
                                                                "disk",
                                                                "site",
                                                                "output",
                                                                "pose",
                                                                "failed",
                                                                "ended"};
  return kNames.at(static_cast<std::size_t>(kind));
}

void EventLog::Add(Event event) {
  const std::lock_guard lock(mutex_);
  counts_[static_cast<std::size_t>(event.kind)] += event.count;
  if (IsSummed(event.kind)) {
    // The last one of its kind that has not been taken.
    const auto same = std::find_if(events_.rbegin(), events_.rend(), [&](const Event& other) {
      return other.kind == event.kind;
    });
    if (same != events_.rend() && std::chrono::abs(event.time - same->time) < kSummedOver) {
      same->count += event.count;
      return;
    }
  }
  events_.push_back(std::move(event));
}

std::vector<Event> EventLog::Take(UtcTime now) {
  const std::lock_guard lock(mutex_);
  // Sums that are still open stay, and so keep their place in time.
  const auto open = std::stable_partition(events_.begin(), events_.end(), [&](const Event& event) {
    return !IsSummed(event.kind) || std::chrono::abs(now - event.time) >= kSummedOver;
  });
  std::vector<Event> taken(std::make_move_iterator(events_.begin()), std::make_move_iterator(open));
  events_.erase(events_.begin(), open);
  return taken;
}

std::vector<Event> EventLog::TakeAll() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

std::int64_t EventLog::CountOf(EventKind kind) const {
  const std::lock_guard lock(mutex_);
  return counts_[static_cast<std::size_t>(kind)];
}

}  // namespace pleinair

// Events of a live run: a drop, a reconnection, a control that was not accepted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "scene/utc_time.h"

namespace pleinair {

// The kind of an event; see NameOf for its text.
enum class EventKind {
  kStarted,
  kPreparing,     // The site is being prepared; pictures pass without objects.
  kPrepared,      // The site: pictures are composited from now on.
  kControl,       // Refused, clamped or missing.
  kClock,         // Stepped, or not synchronised.
  kFrameDropped,  // Older than what the consumer wanted.
  kFrameLost,     // By the driver: its count jumped.
  kFrameDamaged,  // Truncated, or not to be decoded.
  kTimestamp,     // Repeated, or going back.
  kStalled,
  kUnplugged,
  kFormatChanged,
  kReconnected,
  kDisk,
  kSite,    // The site's folder is gone, or back.
  kOutput,  // A place that the picture goes to has failed.
  kPose,    // From outside: refused, or an old one is held.
  kFailed,  // Why the run ends early, where nothing above says it.
  kEnded,
};
inline constexpr std::size_t kEventKinds = static_cast<std::size_t>(EventKind::kEnded) + 1;
// "frame-dropped".
std::string_view NameOf(EventKind kind);

// One line of events.jsonl.
struct Event {
  UtcTime time{};
  EventKind kind = EventKind::kStarted;
  std::string text;        // One line.
  std::int64_t count = 1;  // Number of frames, for drops and losses.
};

// Thread-safe. Frames that are dropped, lost or damaged within a second are one event, and so are
// poses.
class EventLog {
 public:
  void Add(Event event);
  // Returns the events since the last call, in order, without those that may still grow.
  std::vector<Event> Take(UtcTime now);
  std::vector<Event> TakeAll();
  // Over all events so far.
  std::int64_t CountOf(EventKind kind) const;

 private:
  mutable std::mutex mutex_;
  std::vector<Event> events_;
  std::array<std::int64_t, kEventKinds> counts_{};
};

}  // namespace pleinair

// Poses of a camera while it streams, from another program: a tracker.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <tl/expected.hpp>

#include "calib/pose_track.h"
#include "datasets/event.h"
#include "scene/utc_time.h"

namespace pleinair {

// A shared memory slot of 160 bytes with one pose, which a tracker replaces in place. It adds 1 to
// `count` before it writes, which makes it odd, and 1 after. Numbers have the machine's byte order
// (little-endian on x86 and ARM).
struct PoseSlot {
  char magic[8];                 // "plnrpose".
  std::uint32_t version;         // 1.
  std::uint32_t reserved;        // 0.
  std::uint64_t count;           // Count of steps; 0: no pose yet.
  std::int64_t time_utc_ns;      // Since 1970, without leap seconds.
  double camera_from_world[16];  // Row by row.
};
static_assert(sizeof(PoseSlot) == 160);

// Set-up of PoseStream.
struct PoseStreamOptions {
  PoseTrackOptions track;
  // How long a frame waits for a pose at its time or later; 0 or more. After that the last pose is
  // held.
  double wait_s = 0.05;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Reads on a thread of its own, and matches poses to frames by their times (PoseTrack), on the
// machine's UTC clock. An invalid pose is an event, and is ignored. Poses may be out of order by
// kMostDisorderS. Where times go back further, a clock was set: earlier poses are dropped, with an
// event.
class PoseStream {
 public:
  // `source`: "-" (standard input), "shm:NAME" (a PoseSlot in POSIX shared memory, which the
  // tracker has made), or the path of a pipe or file of lines (pose_lines.h). A pipe may lose its
  // writer and get another one; a file is followed as it grows. Throws  std::runtime_error, one
  // line with the source. `events` outlives it.
  PoseStream(const std::string& source, const PoseStreamOptions& options, EventLog& events);
  ~PoseStream();
  PoseStream(const PoseStream&) = delete;
  PoseStream& operator=(const PoseStream&) = delete;

  // Returns the pose at a time, and waits for it as long as the options say. One line where there
  // is none. From any thread.
  tl::expected<TrackPose, std::string> At(UtcTime time);
  // Ends all waiting, now and later. From any thread.
  void Stop();

  static constexpr double kMostDisorderS = 1.0;

 private:
  class Input;
  class LineInput;
  class SlotInput;

  // Why the pose is refused, or others are dropped; empty: neither.
  std::string Take(const TimedPose& pose);

  PoseStreamOptions options_;
  std::string source_;
  EventLog& events_;
  std::unique_ptr<Input> input_;
  std::mutex mutex_;  // Guards the following members.
  std::condition_variable changed_;
  PoseTrack track_;
  bool is_over_ = false;
  std::jthread thread_;
};

}  // namespace pleinair

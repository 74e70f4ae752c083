// Records a camera's pictures in parallel with other uses.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "datasets/camera/camera_capture.h"
#include "datasets/camera/frame_queue.h"
#include "datasets/event.h"
#include "datasets/recording/recording.h"

namespace pleinair {

// Set-up of a recorder.
struct RecorderOptions {
  RecordingOptions recording;
  std::chrono::nanoseconds interval{0};  // Time from a recorded picture to the next; 0: every one.
  // Total size of the pictures that wait for the disk.
  std::uint64_t queue_bytes = 256'000'000;
  // Time between syncs: a power cut loses at most the pictures since the last one.
  std::chrono::milliseconds sync_interval{1000};
};

// Counts of pictures so far.
struct RecorderStatus {
  std::int64_t written = 0;   // Survive a kill of the process.
  std::int64_t finished = 0;  // Survive a power cut.
  std::int64_t dropped = 0;   // The disk was too slow.
  std::int64_t damaged = 0;   // Not decodable, or of another size.
  std::uint64_t bytes = 0;
  std::uint64_t free_bytes = 0;
  std::string stopped;  // Why it has stopped, one line; empty: it has not.
};

// A Recording on a thread of its own. Faults are events.
class Recorder {
 public:
  // Throws as Recording. `events` outlives it.
  Recorder(const Sequence& site,
           const PictureLayout& layout,
           const RecorderOptions& options,
           EventLog& events);
  // As Finish.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Adds a picture without waiting: where the queue is full its oldest picture is dropped. False
  // for a picture that is not recorded: it is before the next interval, or the recorder has
  // stopped.
  bool Offer(CameraFrame frame);
  // Adds an event to the recording's events.jsonl, on the thread.
  void AddEvents(std::vector<Event> events);
  RecorderStatus Status() const;
  // Waits until the queue is written. After that only events are accepted.
  void Close();
  // As Close; then ends the recording, and waits until it is on the disk.
  void Finish();

 private:
  void Write();
  void WriteOne(const CameraFrame& frame);
  void WriteEvents();
  void KeepSynced();
  void Sync();
  // Runs `step`; where the disk fails there, it is false, and nothing more is written.
  bool Guard(const std::function<void()>& step);

  RecorderOptions options_;
  EventLog& events_;
  Recording recording_;
  FrameQueue<CameraFrame> queue_;
  std::optional<std::chrono::nanoseconds> next_due_;  // On the pictures' monotonic clock.
  mutable std::mutex mutex_;                          // Guards the following members.
  RecorderStatus status_;
  std::vector<Event> new_events_;
  bool is_closed_ = false;
  bool is_finished_ = false;
  std::condition_variable closed_;
  std::thread writer_;
  std::thread syncer_;
};

}  // namespace pleinair

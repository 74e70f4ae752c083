// Where a run's frames go: the folder of results, the report, and streams to other programs.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/frame_loop.h"
#include "apps/frame_writer.h"
#include "apps/run_command.h"
#include "apps/run_folder.h"
#include "apps/run_report.h"
#include "apps/run_targets.h"
#include "apps/video_file.h"
#include "datasets/event.h"

namespace pleinair {

// One thread, but for AddEvent, which may be called from another one, and StopWaitingForReaders. A
// stream whose reader is gone is closed, with an event; the run goes on.
class RunOutput {
 public:
  // What an earlier run left stays until the first composite, and where there is none. `targets`
  // and `events` outlive it. `camera_rate`: frames a second, where a camera states it. Throws as
  // RunFolder.
  RunOutput(const RunCommandOptions& options,
            RunTargets& targets,
            EventLog& events,
            std::optional<double> camera_rate = std::nullopt);

  void Add(FinishedFrame frame);
  // Writes a picture that is not composited, unchanged, to the streams and the video alone.
  void AddPassed(const Rgb8Image& picture, UtcTime time);
  void AddEvent(Event event);
  // From any thread: a stream whose reader does not read is closed after a second.
  void StopWaitingForReaders() { targets_.end_of_readers.request_stop(); }
  RunReport& Report() { return report_; }
  // For what is written at a run's end: as SetAside.
  void LeaveRoom() { report_.LeaveRoom(); }

  // Gives the run's names to the files that have them only when complete.
  void Finish();
  // Whether no picture was composited, so that an earlier run's results stay: nothing is written.
  bool KeepsEarlierResults() const;
  // Without pictures where the disk has no room for them.
  void WriteReport();

 private:
  void Begin();
  void AddDone(FinishedFrame frame);
  void NoteFullDisk(UtcTime time);
  // Writes to a stream; where that throws, it is closed.
  template <typename Stream, typename Item>
  void WriteTo(std::optional<Stream>& stream, const Item& item, UtcTime time);

  const RunCommandOptions& options_;
  RunTargets& targets_;
  EventLog& events_;
  RunFolder folder_;
  FrameWriter writer_;
  std::optional<VideoFile> video_;
  RunReport report_;
  bool is_disk_full_ = false;
};

}  // namespace pleinair

// Where a run's frames go: the folder of results, the report, and streams to other programs.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/frame_loop.h"
#include "apps/frame_writer.h"
#include "apps/line_stream.h"
#include "apps/picture_stream.h"
#include "apps/run_command.h"
#include "apps/run_folder.h"
#include "apps/run_report.h"
#include "apps/video_file.h"
#include "datasets/event.h"

namespace pleinair {

// One thread, but for AddEvent, which may be called from another one. A stream whose reader is
// gone is closed, with an event; the run goes on.
class RunOutput {
 public:
  // Locks and clears the folder. Throws as RunFolder. `events` outlives it.
  // `frames_per_second`: of streams.
  RunOutput(const RunCommandOptions& options, EventLog& events, double frames_per_second = 30.0);

  void Add(FinishedFrame frame);
  void AddEvent(Event event);
  RunReport& Report() { return report_; }

  // What has the run's names once it is complete.
  void Finish();
  void WriteReport();

 private:
  void AddDone(FinishedFrame frame);
  // Writes to a stream; where that throws, it is closed.
  template <typename Stream, typename Item>
  void WriteTo(std::optional<Stream>& stream, const Item& item, UtcTime time);

  const RunCommandOptions& options_;
  EventLog& events_;
  RunFolder folder_;
  FrameWriter writer_;
  std::optional<VideoFile> video_;
  std::optional<PictureStream> pictures_;
  std::optional<LineStream> lines_;
  RunReport report_;
};

}  // namespace pleinair

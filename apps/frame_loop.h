// A run's frames one by one, and notes on them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/run_command.h"
#include "session/sequence_session.h"

namespace pleinair {

// A frame that is ready to be written.
struct FinishedFrame {
  SessionStep step;
  Rgb8Image shown;                   // The composite, as the camera would have shown it.
  std::optional<Rgb8Image> input;    // The input as shown, where the frame itself has no codes.
  std::optional<double> latency_ms;  // From taking the picture to its composite: of live frames.
  std::optional<SequenceSession::Environment> environment;
  std::optional<RgbImage> sky;
};

class FrameLoop {
 public:
  // Keeps both. `is_live`: frames do not wait for checks, which then skip some frames.
  FrameLoop(const RunCommandOptions& options, SequenceSession& run, bool is_live = false);
  ~FrameLoop();
  FrameLoop(const FrameLoop&) = delete;
  FrameLoop& operator=(const FrameLoop&) = delete;

  // None at the end. A frame that failed has its error alone.
  std::optional<FinishedFrame> Next();
  // Notes of single frames and of all together: for the report.
  std::vector<std::string> Finish();

 private:
  struct Checks;
  void TakeNotes();
  void Warn(std::string note);
  void CheckSun(const FinishedFrame& finished);

  const RunCommandOptions& options_;
  SequenceSession& run_;
  bool is_live_ = false;
  std::unique_ptr<Checks> checks_;
  std::vector<std::string> notes_;
};

}  // namespace pleinair

// `pleinair run` and `pleinair prepare`: the work behind the arguments.
#pragma once

#include <filesystem>
#include <optional>

#include "session/sequence_session.h"

namespace pleinair {

struct PrepareCommandOptions {
  std::filesystem::path sequence;
  std::filesystem::path cache;  // Empty: the user's cache folder.
  PrepareSettings prepare;
  std::optional<std::filesystem::path> maps;  // Where to write the survey's maps.
};

struct RunCommandOptions : SessionOptions {
  std::filesystem::path out;
  bool stop_on_bad_frame = false;
  bool video = false;
  bool write_environment = false;
  double video_frames_per_second = 10.0;
};

// Throw std::runtime_error or std::invalid_argument, one line. Progress goes to the log.
void RunPrepareCommand(const PrepareCommandOptions& options);
void RunRunCommand(const RunCommandOptions& options);

}  // namespace pleinair

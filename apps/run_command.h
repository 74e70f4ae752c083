// `pleinair run` and `pleinair prepare`: the work behind the arguments.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "datasets/camera/camera.h"
#include "datasets/picture_source.h"
#include "session/sequence_session.h"

namespace pleinair {

struct PrepareCommandOptions {
  std::filesystem::path sequence;
  std::filesystem::path cache;  // Empty: the user's cache folder.
  PrepareSettings prepare;
  std::optional<std::filesystem::path> maps;  // Where to write the survey's maps.
};

// Which pictures of the frames `run` writes.
enum class WrittenPictures {
  kAll,    // Scene-linear composites, composites as shown, masks of what changed.
  kShown,  // Without the scene-linear ones.
  kNone,
};

struct RunCommandOptions : SessionOptions {
  // A camera's name, a video or pictures, at the site that `sequence` then is; empty:
  // the sequence's own frames.
  std::string input;
  CameraRequest camera;
  PictureTimes times;                // Times of a video or pictures.
  std::optional<double> duration_s;  // In camera time; none: until it is stopped.
  std::optional<int> frames_limit;
  std::filesystem::path record;  // Where a camera's frames are recorded to; empty: nowhere.
  std::string picture_stream;    // As PictureStream has it; empty: none.
  std::string lighting_stream;   // As LineStream has it; empty: none.
  std::filesystem::path out;
  std::optional<WrittenPictures> written;  // None: all; of a camera's frames those that are shown.
  bool stop_on_bad_frame = false;
  bool video = false;
  std::optional<double> video_frames_per_second;  // None: a camera's own, or 10.
  bool write_environment = false;
};

// Throw std::runtime_error or std::invalid_argument, one line. Progress goes to the log.
void RunPrepareCommand(const PrepareCommandOptions& options);
void RunRunCommand(const RunCommandOptions& options);

}  // namespace pleinair

// `pleinair record`: a camera's pictures as a sequence.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "datasets/camera/camera.h"
#include "datasets/recording/recorder.h"

namespace pleinair {

struct RecordCommandOptions {
  std::string camera;  // Empty: the one that the site names.
  std::filesystem::path site;
  CameraRequest request;
  RecorderOptions recorder;
  std::optional<double> duration_s;  // From the first picture.
  std::optional<int> frames_limit;   // Pictures to record.
};

// Records until the duration or limit is reached, the camera's stream ends, space is short, or
// SIGINT or SIGTERM comes; the recording is complete in all cases. Prints progress to standard
// error. Returns the exit code: 1 where the disk has ended the recording, or no picture came.
// Throws as OpenCamera, ReadSite and Recorder.
int RunRecordCommand(const RecordCommandOptions& options);

}  // namespace pleinair

// `pleinair view`: the window.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "datasets/camera/camera.h"
#include "datasets/picture_source.h"
#include "session/session_options.h"

namespace pleinair {

struct ViewCommandOptions : SessionOptions {
  // A camera's name, a video or pictures, at the site that `sequence` then is; empty:
  // the sequence's own frames.
  std::string input;
  CameraRequest camera;
  PictureTimes times;
  // Where snapshots and recordings get folders of their own.
  std::filesystem::path out = ".";
  std::vector<std::string> stated_settings;  // "name=value", of the command line and its file.
  bool restores_state = true;                // The window's places and what it showed last.
};

// Until the window is closed. Throws std::invalid_argument for options that the input has no use
// for, as RefuseOtherInputs; std::runtime_error, one line: without a display, or where the
// sequence or the camera cannot be opened.
void RunViewCommand(const ViewCommandOptions& options);

}  // namespace pleinair

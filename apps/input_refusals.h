// Options that do not apply to the input of `run` or `view`: they are refused before work begins.
#pragma once

#include <string>

#include "datasets/camera/camera.h"
#include "datasets/picture_source.h"
#include "session/session_options.h"

namespace pleinair {

// What is played: `site` names a sequence's folder, or with `name` the site of a camera, a video or
// pictures.
struct PlayedInput {
  std::string name;  // Empty: the sequence's own frames.
  CameraRequest camera;
  PictureTimes times;

  bool IsCamera() const;
};

// Each throws std::invalid_argument, one line: the option, what it expects and what was found.

// Options that contradict each other, whatever the input is.
void RefuseContradictions(const SessionOptions& options);
// Options of another kind of input.
void RefuseOtherInputs(const PlayedInput& input, const SessionOptions& options);
// An option for cameras, where the input is none.
void RefuseWithoutCamera(bool is_given, const std::string& option);

}  // namespace pleinair

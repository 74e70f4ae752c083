// Options of commands that open a camera.
#pragma once

#include "datasets/camera/camera.h"

namespace CLI {
class App;
}  // namespace CLI

namespace pleinair {

// --format, --size, --rate, --exposure, --gain, --white-balance and --auto, which set `request`: it
// must outlive `command`. CameraRequest::Validate finds what excludes each other.
void AddCameraOptions(CLI::App& command, CameraRequest& request);

}  // namespace pleinair

// `pleinair cameras`, and the options of commands that open a camera.
#pragma once

#include "apps/arguments.h"
#include "datasets/camera/camera.h"

namespace CLI {
class App;
}  // namespace CLI

namespace pleinair {

// The group of these options in a command's help.
inline constexpr const char* kCameraOptions = "Camera";

// --format, --size, --rate, --exposure, --gain, --white-balance and --auto, which set `request`: it
// must outlive `command`. CameraRequest::Validate finds what excludes each other.
void AddCameraOptions(CLI::App& command, CameraRequest& request);

// Adds `cameras` to `app`; `work` is set when the command is given.
void AddCameras(CLI::App& app, Work& work);

}  // namespace pleinair

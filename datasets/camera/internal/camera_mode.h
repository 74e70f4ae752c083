// Chooses the camera's mode for a request.
#pragma once

#include <string>
#include <vector>

#include "datasets/camera/camera.h"

namespace pleinair {

// The default request.
inline constexpr double kUsualFramesPerSecond = 30.0;

// Returns the mode that is closest to the request: format, size, rate; then the format with the
// least loss. Throws std::runtime_error, one line with the device, where there is no mode at all or
// none of the format.
CameraMode ChooseMode(const std::string& device,
                      const std::vector<CameraMode>& modes,
                      const CameraRequest& request);

}  // namespace pleinair

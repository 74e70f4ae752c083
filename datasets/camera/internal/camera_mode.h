// Which of a camera's modes a request means.
#pragma once

#include <string>
#include <vector>

#include "datasets/camera/camera.h"

namespace pleinair {

// What is asked for where nothing is stated.
inline constexpr double kUsualFramesPerSecond = 30.0;

// The mode that is closest to what is asked for: format, size, rate; then the format in which least
// is lost. Throws std::runtime_error, one line with the device, where there is no mode at all or
// none of the format.
CameraMode ChooseMode(const std::string& device,
                      const std::vector<CameraMode>& modes,
                      const CameraRequest& request);

}  // namespace pleinair

// Cameras through V4L2: streaming into memory that the driver shares.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "datasets/camera/camera.h"

namespace pleinair {

// As ListCameras, OpenCamera and FindCamera, for /dev/videoN. Numbers are tried one by one, which
// also finds stand-ins.
CameraList ListV4l2Cameras();
std::unique_ptr<CameraStream> OpenV4l2Camera(const std::string& device,
                                             const CameraRequest& request);
std::optional<std::string> FindV4l2Camera(const std::string& identity);

// Devices that other programs see as cameras while a program writes pictures to them.
std::vector<std::string> ListLoopbackDevices();

}  // namespace pleinair

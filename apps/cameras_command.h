// `pleinair cameras`: what OpenCamera can open.
#pragma once

#include <string>

#include "datasets/camera/camera.h"

namespace pleinair {

// Both return what is to be printed, with its last line end. What drivers and products are called
// is shown as MessageText has it.
std::string CamerasText(const CameraList& list);
std::string CamerasJson(const CameraList& list);

}  // namespace pleinair

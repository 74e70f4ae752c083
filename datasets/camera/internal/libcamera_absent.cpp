// In place of libcamera_camera.cpp where CMake finds no libcamera.
#include <stdexcept>

#include "datasets/camera/libcamera_camera.h"

namespace pleinair {
namespace {

constexpr const char* kMissing =
    "pleinair was built without libcamera: install libcamera-dev and build it again";

}  // namespace

std::string LibcameraVersion() { return {}; }

CameraList ListLibcameraCameras() { return {{}, {}, kMissing}; }

std::unique_ptr<CameraStream> OpenLibcameraCamera(const std::string& device,
                                                  const CameraRequest& /*request*/) {
  throw std::runtime_error(device + ": " + kMissing);
}

std::optional<std::string> FindLibcameraCamera(const std::string& /*identity*/) {
  return std::nullopt;
}

}  // namespace pleinair

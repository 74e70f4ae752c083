#include "datasets/camera/camera.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "datasets/camera/libcamera_camera.h"
#include "datasets/camera/v4l2_camera.h"

namespace pleinair {
namespace {

void RequirePositive(const char* name, std::optional<double> value) {
  if (!value || (*value > 0.0 && std::isfinite(*value))) return;
  throw std::invalid_argument(fmt::format("{}: expected a number above 0, found {}", name, *value));
}

constexpr const char* kDevicePrefix = "/dev/video";

// Where a link leads; any other name is itself.
std::string WithoutLink(const std::string& name) {
  std::error_code error;
  const std::filesystem::path target = std::filesystem::read_symlink(name, error);
  if (error) return name;
  return (std::filesystem::path(name).parent_path() / target).lexically_normal().string();
}

}  // namespace

void CameraRequest::Validate() const {
  RequirePositive("camera frames per second", frames_per_second);
  RequirePositive("camera exposure", exposure_s);
  if (gain && !(*gain >= 0.0 && std::isfinite(*gain))) {
    throw std::invalid_argument(fmt::format("camera gain: expected 0 or more, found {}", *gain));
  }
  RequirePositive("camera white balance", white_balance_k);
  for (const std::optional<int>& side : {width_px, height_px}) {
    if (side && *side < 1) {
      throw std::invalid_argument(fmt::format("camera size: expected 1 or more, found {}", *side));
    }
  }
  if (reference_gain && !std::isfinite(*reference_gain)) {
    throw std::invalid_argument(
        fmt::format("camera reference gain: expected a number, found {}", *reference_gain));
  }
  if (automatic && (exposure_s || gain || white_balance_k)) {
    throw std::invalid_argument(
        "camera: expected automatic controls or values for them, found both");
  }
  if (ControlDelayFrames() < 0) {
    throw std::invalid_argument(
        fmt::format("camera control delay: expected 0 or more, found {}", ControlDelayFrames()));
  }
  if (development) development->Validate();
}

std::optional<double> IsoOf(const CapturedExposure& exposure) {
  if (!exposure.gain) return std::nullopt;
  return 100.0 * *exposure.gain;
}

CameraList ListCameras() {
  CameraList list = ListV4l2Cameras();
  CameraList more = ListLibcameraCameras();
  std::move(more.cameras.begin(), more.cameras.end(), std::back_inserter(list.cameras));
  list.libcamera_failure = std::move(more.libcamera_failure);
  return list;
}

bool IsCameraName(const std::string& name) {
  return name.starts_with(kLibcameraPrefix) || name.starts_with("/dev/v4l/") ||
         WithoutLink(name).starts_with(kDevicePrefix);
}

std::unique_ptr<CameraStream> OpenCamera(const std::string& device, const CameraRequest& request) {
  request.Validate();
  return device.starts_with(kLibcameraPrefix) ? OpenLibcameraCamera(device, request)
                                              : OpenV4l2Camera(WithoutLink(device), request);
}

std::optional<std::string> FindCamera(const std::string& identity) {
  return identity.starts_with(kLibcameraPrefix) ? FindLibcameraCamera(identity)
                                                : FindV4l2Camera(identity);
}

}  // namespace pleinair

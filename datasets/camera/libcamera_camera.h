// Cameras through libcamera: those whose pictures need a pipeline that it sets up (most cameras of
// small boards), and webcams too.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "datasets/camera/camera.h"

namespace pleinair {

// "libcamera:ID" is a camera's device and its identity; ID is libcamera's.
inline constexpr const char* kLibcameraPrefix = "libcamera:";

// Version of the library; empty where pleinair was built without it.
std::string LibcameraVersion();

// As ListCameras, OpenCamera and FindCamera. The first call starts libcamera, which runs until the
// program ends. Its log is dropped, unless LIBCAMERA_LOG_FILE names a file.
CameraList ListLibcameraCameras();
std::unique_ptr<CameraStream> OpenLibcameraCamera(const std::string& device,
                                                  const CameraRequest& request);
std::optional<std::string> FindLibcameraCamera(const std::string& identity);

}  // namespace pleinair

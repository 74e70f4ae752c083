// An open V4L2 device: its calls, with what they fail of.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/camera/camera.h"

namespace pleinair {

// Closes it when destroyed.
class V4l2Device {
 public:
  // None where it cannot be opened; `error_number` is then errno's.
  static std::optional<V4l2Device> Open(const std::string& path, int& error_number);
  ~V4l2Device();
  V4l2Device(V4l2Device&& other) noexcept;
  V4l2Device& operator=(V4l2Device&&) = delete;

  const std::string& Path() const { return path_; }
  int Descriptor() const { return descriptor_; }

  // 0, or errno's value.
  int Call(unsigned long request, void* argument) const;

  // None where it is no camera by itself that streams in one plane.
  std::optional<v4l2_capability> Camera() const;
  std::vector<CameraMode> Modes() const;
  std::vector<CameraControl> Controls() const;

  std::optional<v4l2_queryctrl> QueryControl(std::uint32_t id) const;
  std::optional<int> GetControl(std::uint32_t id) const;
  int SetControl(std::uint32_t id, int value) const;  // As Call.

 private:
  V4l2Device(std::string path, int descriptor);

  std::string path_;
  int descriptor_ = -1;
};

std::string CardOf(const v4l2_capability& camera);

// "card|bus_info", which all nodes of a device share; on USB the second is the port.
std::string PortOf(const v4l2_capability& camera);

// Of the camera at /dev/video`number`: "vendor:product:serial:index" of a device that has a serial
// number, at any port, as `sysfs` states them; else PortOf and "|index". The index is the node's
// place within its device.
std::string IdentityOf(int number,
                       const v4l2_capability& camera,
                       const std::filesystem::path& sysfs = "/sys/class/video4linux");

}  // namespace pleinair

// An open V4L2 device: its calls, with what they fail of.
#pragma once

#include <linux/videodev2.h>
#include <sys/time.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/camera/camera.h"

namespace pleinair {

// A buffer of the driver's, in one piece of memory.
struct DriverBuffer {
  std::uint32_t index = 0;
  std::uint32_t flags = 0;
  std::uint32_t sequence = 0;
  timeval timestamp{};
  std::uint32_t map_offset = 0;  // Offset for mmap.
  std::uint32_t length_bytes = 0;
  // The picture in it.
  std::uint32_t picture_begin = 0;
  std::uint32_t picture_end = 0;
};

// Single-planar, or multi-planar with formats whose planes are in one piece of memory. Closes it
// when destroyed.
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

  // Type of its buffers: V4L2_BUF_TYPE_VIDEO_CAPTURE, or the same with planes.
  std::uint32_t BufferType() const { return buffer_type_; }
  // As Call, of VIDIOC_G_FMT, S_FMT and TRY_FMT. EINVAL: planes in several pieces of memory.
  int CallWithFormat(unsigned long request, v4l2_pix_format& format) const;
  // As Call, of VIDIOC_QUERYBUF, QBUF and DQBUF.
  int CallWithBuffer(unsigned long request, DriverBuffer& buffer) const;

  // None where it is no camera by itself that streams, or a loopback device without a writer.
  std::optional<v4l2_capability> Camera() const;
  bool IsLoopback() const;
  std::vector<CameraMode> Modes() const;
  std::vector<CameraControl> Controls() const;

  std::optional<int> GetControl(std::uint32_t id) const;
  int SetControl(std::uint32_t id, int value) const;  // As Call.

 private:
  V4l2Device(std::string path, int descriptor);
  bool IsMultiPlanar() const { return buffer_type_ == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }

  std::string path_;
  int descriptor_ = -1;
  std::uint32_t buffer_type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE;
};

std::string CardOf(const v4l2_capability& camera);

// "card|bus_info", which all nodes of a device share; on USB the second is the port.
std::string PortOf(const v4l2_capability& camera);

// Identity of the camera at /dev/video`number`. With a serial number it is
// "vendor:product:serial:index", at any port, as `sysfs` states them; else PortOf and "|index". The
// index is the node's place within its device.
std::string IdentityOf(int number,
                       const v4l2_capability& camera,
                       const std::filesystem::path& sysfs = "/sys/class/video4linux");

}  // namespace pleinair

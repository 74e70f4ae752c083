#include "apps/video_output.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include <fmt/format.h>

namespace pleinair {
namespace {

constexpr const char* kLoopback = "v4l2 loopback";

template <std::size_t kSize>
std::string Text(const __u8 (&field)[kSize]) {
  const auto* text = reinterpret_cast<const char*>(field);
  return {text, strnlen(text, kSize)};
}

// "YUYV"; what is no letter is a dot.
std::string FourccText(std::uint32_t fourcc) {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const auto letter = static_cast<char>(fourcc >> (8 * i) & 0x7f);
    text += letter > ' ' && letter < 0x7f ? letter : '.';
  }
  return text;
}

// Makes this opener the device's writer for version 0.12 of the loopback driver. Later versions
// know their writer without it, and may refuse it.
void StartStream(const Descriptor& device) {
  std::uint32_t type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  ioctl(device.Number(), VIDIOC_STREAMON, &type);
}

}  // namespace

Descriptor OpenVideoOutput(const std::string& device, const std::string& name) {
  for (bool is_first = true;; is_first = false) {
    const int number = open(device.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
    if (number < 0) {
      throw std::runtime_error(name + ": expected a loopback device: " + std::strerror(errno));
    }
    Descriptor opened(number);
    v4l2_capability found{};
    if (ioctl(opened.Number(), VIDIOC_QUERYCAP, &found) != 0) {
      throw std::runtime_error(name + ": expected a loopback device, found no V4L2 device");
    }
    const std::uint32_t can =
        (found.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? found.device_caps : found.capabilities;
    const std::string driver = Text(found.driver);
    const bool takes_pictures =
        (can & V4L2_CAP_VIDEO_OUTPUT) != 0 && (can & V4L2_CAP_READWRITE) != 0;
    // With exclusive_caps=1 it is a camera alone while a program reads what an earlier one wrote.
    const bool is_read = driver == kLoopback && (can & V4L2_CAP_VIDEO_CAPTURE) != 0;
    if (takes_pictures || is_read) return opened;
    if (driver != kLoopback || !is_first) {
      throw std::runtime_error(fmt::format(
          "{}: expected a loopback device, found {} ({})", name, Text(found.card), driver));
    }
    // With exclusive_caps=1, version 0.12 no longer takes pictures once a program has written some
    // without starting a stream. It does again when one that starts a stream has closed it.
    StartStream(opened);
  }
}

void SetVideoOutput(const Descriptor& device,
                    const std::string& name,
                    int width_px,
                    int height_px,
                    double frames_per_second) {
  if (width_px % 2 != 0) {
    throw std::runtime_error(
        fmt::format("{}: expected an even width for YUYV, found {}", name, width_px));
  }
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  v4l2_pix_format& pix = format.fmt.pix;
  pix.width = static_cast<std::uint32_t>(width_px);
  pix.height = static_cast<std::uint32_t>(height_px);
  pix.pixelformat = V4L2_PIX_FMT_YUYV;
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = 2 * pix.width;
  pix.sizeimage = pix.bytesperline * pix.height;
  // YUYV of this colour space has the matrix of BT.601 and limited range.
  pix.colorspace = V4L2_COLORSPACE_SRGB;
  const v4l2_pix_format wanted = pix;
  const std::string expected =
      fmt::format("{}: expected a device that takes YUYV of {}x{}", name, width_px, height_px);
  if (ioctl(device.Number(), VIDIOC_S_FMT, &format) != 0) {
    throw std::runtime_error(
        expected + ": " +
        (errno == EBUSY ? "another program uses the device" : std::strerror(errno)));
  }
  if (pix.pixelformat != wanted.pixelformat || pix.width != wanted.width ||
      pix.height != wanted.height || pix.bytesperline != wanted.bytesperline ||
      pix.sizeimage < wanted.sizeimage) {
    throw std::runtime_error(fmt::format("{}, found {} of {}x{} in rows of {} bytes",
                                         expected,
                                         FourccText(pix.pixelformat),
                                         pix.width,
                                         pix.height,
                                         pix.bytesperline));
  }
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  parameters.parm.output.timeperframe.numerator = 1000;
  parameters.parm.output.timeperframe.denominator =
      static_cast<std::uint32_t>(std::max(std::lround(1000.0 * frames_per_second), 1L));
  ioctl(device.Number(), VIDIOC_S_PARM, &parameters);  // Not all drivers have a rate.
  // So that it is an output again once it is closed; see above. Others stream when they are
  // written.
  v4l2_capability found{};
  if (ioctl(device.Number(), VIDIOC_QUERYCAP, &found) == 0 && Text(found.driver) == kLoopback) {
    StartStream(device);
  }
}

}  // namespace pleinair

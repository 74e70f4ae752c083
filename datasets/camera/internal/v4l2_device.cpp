#include "datasets/camera/internal/v4l2_device.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <utility>

namespace pleinair {
namespace {

// Limit for a driver whose list never ends.
constexpr std::uint32_t kMostEntries = 256;

// Sizes that are listed for a driver with a range, as far as they lie in the range.
constexpr std::array<std::pair<int, int>, 7> kUsualSizes = {
    {{320, 240}, {640, 480}, {800, 600}, {1280, 720}, {1280, 960}, {1920, 1080}, {3840, 2160}}};

template <std::size_t kSize>
std::string Text(const __u8 (&field)[kSize]) {
  const auto* text = reinterpret_cast<const char*>(field);
  return {text, strnlen(text, kSize)};
}

double RateOf(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0.0
                                 : static_cast<double>(interval.denominator) / interval.numerator;
}

std::vector<double> RatesOf(const V4l2Device& device,
                            std::uint32_t fourcc,
                            std::uint32_t width,
                            std::uint32_t height) {
  std::vector<double> rates;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_frmivalenum entry{};
    entry.index = i;
    entry.pixel_format = fourcc;
    entry.width = width;
    entry.height = height;
    if (device.Call(VIDIOC_ENUM_FRAMEINTERVALS, &entry) != 0) break;
    if (entry.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      rates.push_back(RateOf(entry.discrete));
      continue;
    }
    // A range: its ends.
    rates.push_back(RateOf(entry.stepwise.min));
    rates.push_back(RateOf(entry.stepwise.max));
    break;
  }
  std::erase_if(rates, [](double rate) { return !(rate > 0.0); });
  std::sort(rates.begin(), rates.end(), std::greater<>());
  rates.erase(std::unique(rates.begin(), rates.end()), rates.end());
  return rates;
}

std::vector<std::pair<int, int>> SizesOf(const V4l2Device& device, std::uint32_t fourcc) {
  std::vector<std::pair<int, int>> sizes;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_frmsizeenum entry{};
    entry.index = i;
    entry.pixel_format = fourcc;
    if (device.Call(VIDIOC_ENUM_FRAMESIZES, &entry) != 0) break;
    if (entry.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      sizes.emplace_back(entry.discrete.width, entry.discrete.height);
      continue;
    }
    const v4l2_frmsize_stepwise& range = entry.stepwise;
    sizes.emplace_back(range.min_width, range.min_height);
    for (const auto& [width, height] : kUsualSizes) {
      const auto fits = [](int side, std::uint32_t least, std::uint32_t most, std::uint32_t step) {
        const auto value = static_cast<std::uint32_t>(side);
        return value > least && value < most && (step == 0 || (value - least) % step == 0);
      };
      if (fits(width, range.min_width, range.max_width, range.step_width) &&
          fits(height, range.min_height, range.max_height, range.step_height)) {
        sizes.emplace_back(width, height);
      }
    }
    sizes.emplace_back(range.max_width, range.max_height);
    break;
  }
  // A video input lists none: it has its signal's.
  v4l2_pix_format now{};
  if (sizes.empty() && device.CallWithFormat(VIDIOC_G_FMT, now) == 0) {
    sizes.emplace_back(now.width, now.height);
  }
  return sizes;
}

std::string UnitOf(std::uint32_t control) {
  switch (control) {
    case V4L2_CID_EXPOSURE_ABSOLUTE:
      return "100 us";
    case V4L2_CID_WHITE_BALANCE_TEMPERATURE:
      return "K";
    default:
      return {};
  }
}

// Content of a file of sysfs; empty where it is absent.
std::string LineOf(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

// Number of nodes of the same device with lower numbers.
int NodesBefore(int number, const std::string& port) {
  int nodes = 0;
  for (int other = 0; other < number; ++other) {
    int error = 0;
    const auto device = V4l2Device::Open("/dev/video" + std::to_string(other), error);
    if (!device) continue;
    const std::optional<v4l2_capability> camera = device->Camera();
    if (camera && PortOf(*camera) == port) ++nodes;
  }
  return nodes;
}

// Capabilities of this node only.
std::uint32_t CapabilitiesOf(const v4l2_capability& found) {
  return (found.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? found.device_caps : found.capabilities;
}

}  // namespace

V4l2Device::V4l2Device(std::string path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {
  v4l2_capability found{};
  if (Call(VIDIOC_QUERYCAP, &found) != 0) return;
  constexpr std::uint32_t kEither = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE;
  if ((CapabilitiesOf(found) & kEither) == V4L2_CAP_VIDEO_CAPTURE_MPLANE) {
    buffer_type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  }
}

V4l2Device::V4l2Device(V4l2Device&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      buffer_type_(other.buffer_type_) {}

V4l2Device::~V4l2Device() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::optional<V4l2Device> V4l2Device::Open(const std::string& path, int& error_number) {
  const int descriptor = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  error_number = descriptor < 0 ? errno : 0;
  if (descriptor < 0) return std::nullopt;
  return V4l2Device(path, descriptor);
}

int V4l2Device::Call(unsigned long request, void* argument) const {
  while (ioctl(descriptor_, request, argument) != 0) {
    if (errno != EINTR) return errno;
  }
  return 0;
}

int V4l2Device::CallWithFormat(unsigned long request, v4l2_pix_format& format) const {
  v4l2_format call{};
  call.type = buffer_type_;
  if (!IsMultiPlanar()) {
    call.fmt.pix = format;
    const int error = Call(request, &call);
    format = call.fmt.pix;
    return error;
  }
  v4l2_pix_format_mplane& planes = call.fmt.pix_mp;
  planes.width = format.width;
  planes.height = format.height;
  planes.pixelformat = format.pixelformat;
  planes.field = format.field;
  planes.num_planes = 1;
  if (const int error = Call(request, &call); error != 0) return error;
  if (planes.num_planes != 1) return EINVAL;
  format = {};
  format.width = planes.width;
  format.height = planes.height;
  format.pixelformat = planes.pixelformat;
  format.field = planes.field;
  format.bytesperline = planes.plane_fmt[0].bytesperline;
  format.sizeimage = planes.plane_fmt[0].sizeimage;
  format.colorspace = planes.colorspace;
  format.ycbcr_enc = planes.ycbcr_enc;
  format.quantization = planes.quantization;
  format.xfer_func = planes.xfer_func;
  return 0;
}

int V4l2Device::CallWithBuffer(unsigned long request, DriverBuffer& buffer) const {
  v4l2_buffer call{};
  v4l2_plane plane{};
  call.index = buffer.index;
  call.type = buffer_type_;
  call.memory = V4L2_MEMORY_MMAP;
  if (IsMultiPlanar()) {
    call.m.planes = &plane;
    call.length = 1;
  }
  if (const int error = Call(request, &call); error != 0) return error;
  buffer = {call.index, call.flags, call.sequence, call.timestamp};
  if (IsMultiPlanar()) {
    buffer.map_offset = plane.m.mem_offset;
    buffer.length_bytes = plane.length;
    buffer.picture_begin = plane.data_offset;
    buffer.picture_end = plane.bytesused;
  } else {
    buffer.map_offset = call.m.offset;
    buffer.length_bytes = call.length;
    buffer.picture_end = call.bytesused;
  }
  return 0;
}

std::optional<v4l2_capability> V4l2Device::Camera() const {
  v4l2_capability camera{};
  if (Call(VIDIOC_QUERYCAP, &camera) != 0) return std::nullopt;
  const std::uint32_t can = CapabilitiesOf(camera);
  constexpr std::uint32_t kEither = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE;
  if ((can & kEither) == 0 || (can & V4L2_CAP_STREAMING) == 0) return std::nullopt;
  // The end of a pipeline that someone has to set up first: libcamera does.
  if ((can & V4L2_CAP_IO_MC) != 0) return std::nullopt;
  // It has a format from the first picture that a program writes to it.
  v4l2_fmtdesc first{};
  first.type = buffer_type_;
  if (IsLoopback() && Call(VIDIOC_ENUM_FMT, &first) != 0) return std::nullopt;
  return camera;
}

bool V4l2Device::IsLoopback() const {
  v4l2_capability found{};
  return Call(VIDIOC_QUERYCAP, &found) == 0 && Text(found.driver) == "v4l2 loopback";
}

std::vector<CameraMode> V4l2Device::Modes() const {
  std::vector<CameraMode> modes;
  for (std::uint32_t i = 0; i < kMostEntries; ++i) {
    v4l2_fmtdesc description{};
    description.index = i;
    description.type = buffer_type_;
    if (Call(VIDIOC_ENUM_FMT, &description) != 0) break;
    const std::optional<PixelFormat> format = PixelFormatOf(description.pixelformat);
    if (!format) continue;
    for (const auto& [width, height] : SizesOf(*this, description.pixelformat)) {
      modes.push_back({*format,
                       width,
                       height,
                       RatesOf(*this,
                               description.pixelformat,
                               static_cast<std::uint32_t>(width),
                               static_cast<std::uint32_t>(height))});
    }
  }
  return modes;
}

std::vector<CameraControl> V4l2Device::Controls() const {
  std::vector<CameraControl> controls;
  v4l2_queryctrl query{};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  for (std::uint32_t i = 0; i < kMostEntries && Call(VIDIOC_QUERYCTRL, &query) == 0; ++i) {
    const bool is_number = query.type == V4L2_CTRL_TYPE_INTEGER ||
                           query.type == V4L2_CTRL_TYPE_BOOLEAN ||
                           query.type == V4L2_CTRL_TYPE_MENU;
    if (is_number && (query.flags & V4L2_CTRL_FLAG_DISABLED) == 0) {
      const std::optional<int> value = GetControl(query.id);
      controls.push_back({Text(query.name),
                          static_cast<double>(query.minimum),
                          static_cast<double>(query.maximum),
                          static_cast<double>(value.value_or(query.default_value)),
                          static_cast<double>(query.default_value),
                          UnitOf(query.id),
                          (query.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0});
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return controls;
}

std::optional<int> V4l2Device::GetControl(std::uint32_t id) const {
  v4l2_control control{id, 0};
  if (Call(VIDIOC_G_CTRL, &control) != 0) return std::nullopt;
  return control.value;
}

int V4l2Device::SetControl(std::uint32_t id, int value) const {
  v4l2_control control{id, value};
  return Call(VIDIOC_S_CTRL, &control);
}

std::string CardOf(const v4l2_capability& camera) { return Text(camera.card); }

std::string PortOf(const v4l2_capability& camera) {
  return CardOf(camera) + "|" + Text(camera.bus_info);
}

std::string IdentityOf(int number,
                       const v4l2_capability& camera,
                       const std::filesystem::path& sysfs) {
  const std::filesystem::path node = sysfs / ("video" + std::to_string(number));
  // `device` is the USB interface; its parent is the device.
  const std::string serial = LineOf(node / "device/../serial");
  const std::string vendor = LineOf(node / "device/../idVendor");
  const std::string product = LineOf(node / "device/../idProduct");
  std::string index = LineOf(node / "index");
  if (index.empty()) index = std::to_string(NodesBefore(number, PortOf(camera)));
  if (serial.empty() || vendor.empty() || product.empty()) return PortOf(camera) + "|" + index;
  return vendor + ":" + product + ":" + serial + ":" + index;
}

}  // namespace pleinair

#include "datasets/camera/v4l2_camera.h"

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "datasets/camera/internal/camera_lock.h"
#include "datasets/camera/internal/camera_mode.h"
#include "datasets/camera/internal/read_clock.h"
#include "datasets/camera/internal/v4l2_device.h"

namespace pleinair {
namespace {

constexpr int kMostNumbers = 256;
constexpr std::uint32_t kBuffers = 4;

constexpr std::string_view kPrefix = "/dev/video";

std::string PathOf(int number) { return std::string(kPrefix) + std::to_string(number); }

// -1: of another name.
int NumberOf(std::string_view path) {
  if (!path.starts_with(kPrefix)) return -1;
  path.remove_prefix(kPrefix.size());
  int number = -1;
  const auto [end, error] = std::from_chars(path.data(), path.data() + path.size(), number);
  return error == std::errc() && end == path.data() + path.size() ? number : -1;
}

[[noreturn]] void Refuse(const std::string& device, const std::string& why) {
  throw std::runtime_error(device + ": " + why);
}

std::string ReasonOf(int error) {
  return error == EBUSY ? "another program uses the camera" : std::strerror(error);
}

YuvCoding YuvCodingOf(const v4l2_pix_format& pix) {
  std::uint32_t encoding = pix.ycbcr_enc;
  if (encoding == V4L2_YCBCR_ENC_DEFAULT) encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(pix.colorspace);
  std::uint32_t range = pix.quantization;
  if (range == V4L2_QUANTIZATION_DEFAULT) {
    range = V4L2_MAP_QUANTIZATION_DEFAULT(false, pix.colorspace, encoding);
  }
  YuvCoding coding;
  if (encoding == V4L2_YCBCR_ENC_709 || encoding == V4L2_YCBCR_ENC_XV709) {
    coding.matrix = YuvMatrix::kBt709;
  } else if (encoding == V4L2_YCBCR_ENC_BT2020) {
    coding.matrix = YuvMatrix::kBt2020;
  }
  coding.is_full_range = range == V4L2_QUANTIZATION_FULL_RANGE;
  return coding;
}

v4l2_pix_format FormatOf(const PixelFormat& pixels, int width_px, int height_px) {
  v4l2_pix_format format{};
  format.width = static_cast<std::uint32_t>(width_px);
  format.height = static_cast<std::uint32_t>(height_px);
  format.pixelformat = FourccOf(pixels);
  format.field = V4L2_FIELD_NONE;
  return format;
}

PictureLayout LayoutOf(const std::string& device, const v4l2_pix_format& pix) {
  const std::optional<PixelFormat> format = PixelFormatOf(pix.pixelformat);
  if (!format) Refuse(device, "the driver chose a format that cannot be decoded");
  return {*format,
          static_cast<int>(pix.width),
          static_cast<int>(pix.height),
          static_cast<int>(pix.bytesperline),
          YuvCodingOf(pix)};
}

// A buffer of the driver's, mapped into our memory.
class MappedBuffer {
 public:
  MappedBuffer(const V4l2Device& device, const DriverBuffer& buffer)
      : length_(buffer.length_bytes) {
    start_ = mmap(nullptr,
                  length_,
                  PROT_READ | PROT_WRITE,
                  MAP_SHARED,
                  device.Descriptor(),
                  static_cast<off_t>(buffer.map_offset));
    if (start_ == MAP_FAILED) Refuse(device.Path(), std::string("mmap: ") + std::strerror(errno));
  }
  ~MappedBuffer() {
    if (start_ != MAP_FAILED) munmap(start_, length_);
  }
  MappedBuffer(MappedBuffer&& other) noexcept
      : start_(std::exchange(other.start_, MAP_FAILED)), length_(other.length_) {}
  MappedBuffer& operator=(MappedBuffer&&) = delete;

  // Copies the bytes of the picture in the buffer.
  std::vector<std::byte> Copy(const DriverBuffer& filled) const {
    const auto* data = static_cast<const std::byte*>(start_);
    const std::size_t end = std::min<std::size_t>(filled.picture_end, length_);
    return {data + std::min<std::size_t>(filled.picture_begin, end), data + end};
  }

 private:
  void* start_ = MAP_FAILED;
  std::size_t length_ = 0;
};

class V4l2Stream final : public CameraStream {
 public:
  V4l2Stream(V4l2Device device, const v4l2_capability& camera, const CameraRequest& request)
      : device_(std::move(device)),
        is_loopback_(device_.IsLoopback()),
        identity_(IdentityOf(NumberOf(device_.Path()), camera)),
        development_(request.development) {
    SetMode(request);
    lock_.emplace(device_, request);
    StartStreaming();
    if (layout_.format.coding == PixelCoding::kBayer && !development_) {
      development_ = UsualDevelopment(layout_.format.bits);
      // Few drivers state it.
      if (const auto black = device_.GetControl(V4L2_CID_BLACK_LEVEL)) {
        development_->black_level = *black;
      }
      development_->Validate();
    }
    frames_to_pass_ = lock_->HasToSettle() ? CameraLock::kSettleFrames : 0;
  }

  // Stops the stream before the buffers are unmapped and the device is closed.
  ~V4l2Stream() override {
    std::uint32_t type = device_.BufferType();
    device_.Call(VIDIOC_STREAMOFF, &type);
  }

  tl::expected<CapturedBuffer, CameraFault> Next(std::chrono::milliseconds timeout) override {
    auto buffer = Dequeue(timeout);
    if (!buffer || frames_to_pass_ == 0) return buffer;
    if (--frames_to_pass_ == 0 && lock_->HasToSettle()) {
      lock_->Settle();
      frames_to_pass_ = lock_->DelayFrames();
    }
    return Fault(CameraFaultKind::kSettling, "the camera settles");
  }

  const PictureLayout& Layout() const override { return layout_; }
  double FramesPerSecond() const override { return frames_per_second_; }
  const std::string& Identity() const override { return identity_; }
  CameraSettings Settings() const override { return lock_->Settings(); }
  std::vector<std::string> TakeNotes() override {
    std::vector<std::string> notes = lock_->TakeNotes();
    notes.insert(notes.begin(), notes_.begin(), notes_.end());
    notes_.clear();
    return notes;
  }

 private:
  void SetMode(const CameraRequest& request) {
    // Before the signal is read: no later change may be missed. Most cameras have no such event.
    v4l2_event_subscription source{};
    source.type = V4L2_EVENT_SOURCE_CHANGE;
    device_.Call(VIDIOC_SUBSCRIBE_EVENT, &source);
    TakeSignal();
    const CameraMode mode = ChooseMode(device_.Path(), device_.Modes(), request);
    v4l2_pix_format format = FormatOf(mode.format, mode.width_px, mode.height_px);
    if (request.width_px && request.height_px) {
      // A driver with a range of sizes can have more than those that are listed.
      const v4l2_pix_format asked = FormatOf(mode.format, *request.width_px, *request.height_px);
      v4l2_pix_format wanted = asked;
      if (device_.CallWithFormat(VIDIOC_TRY_FMT, wanted) == 0 && wanted.width == asked.width &&
          wanted.height == asked.height && wanted.pixelformat == asked.pixelformat) {
        format = wanted;
      }
    }
    if (const int error = device_.CallWithFormat(VIDIOC_S_FMT, format); error != 0) {
      Refuse(device_.Path(), "setting the format: " + ReasonOf(error));
    }
    layout_ = LayoutOf(device_.Path(), format);
    if (request.width_px.value_or(layout_.width_px) != layout_.width_px ||
        request.height_px.value_or(layout_.height_px) != layout_.height_px) {
      notes_.push_back(fmt::format("{}: size: expected {}x{}, the camera's closest is {}x{}",
                                   device_.Path(),
                                   request.width_px.value_or(layout_.width_px),
                                   request.height_px.value_or(layout_.height_px),
                                   layout_.width_px,
                                   layout_.height_px));
    }

    v4l2_streamparm parameters{};
    parameters.type = device_.BufferType();
    // Thousandths hold all usual rates, 29.97 included, exactly enough.
    parameters.parm.capture.timeperframe.numerator = 1000;
    parameters.parm.capture.timeperframe.denominator = static_cast<std::uint32_t>(
        std::lround(1000.0 * request.frames_per_second.value_or(kUsualFramesPerSecond)));
    const int error = device_.Call(VIDIOC_S_PARM, &parameters);
    if (const v4l2_fract& interval = parameters.parm.capture.timeperframe;
        error == 0 && interval.numerator > 0) {
      frames_per_second_ = static_cast<double>(interval.denominator) / interval.numerator;
    }
    // 29.97 is 30.
    constexpr double kSameRate = 0.01;
    if (const std::optional<double> asked = request.frames_per_second;
        asked && !(std::abs(frames_per_second_ / *asked - 1.0) <= kSameRate)) {
      notes_.push_back(fmt::format(
          "{}: rate: expected {:g} pictures a second, {}",
          device_.Path(),
          *asked,
          error != 0 ? std::string("refused: ") + ReasonOf(error)
                     : fmt::format("the camera's closest is {:g}", frames_per_second_)));
    }
  }

  // A video input (HDMI) captures with the timings that it is set to: those of its signal.
  void TakeSignal() {
    v4l2_dv_timings signal{};
    if (device_.Call(VIDIOC_QUERY_DV_TIMINGS, &signal) == 0) {
      device_.Call(VIDIOC_S_DV_TIMINGS, &signal);
    }
  }

  void StartStreaming() {
    v4l2_requestbuffers request{};
    request.count = kBuffers;
    request.type = device_.BufferType();
    request.memory = V4L2_MEMORY_MMAP;
    if (const int error = device_.Call(VIDIOC_REQBUFS, &request); error != 0) {
      Refuse(device_.Path(), "asking for buffers: " + ReasonOf(error));
    }
    if (request.count < 2) Refuse(device_.Path(), "expected 2 buffers or more, found fewer");
    for (std::uint32_t i = 0; i < request.count; ++i) {
      DriverBuffer buffer{.index = i};
      if (const int error = device_.CallWithBuffer(VIDIOC_QUERYBUF, buffer); error != 0) {
        Refuse(device_.Path(), "a buffer: " + ReasonOf(error));
      }
      buffers_.emplace_back(device_, buffer);
      if (const int error = device_.CallWithBuffer(VIDIOC_QBUF, buffer); error != 0) {
        Refuse(device_.Path(), "a buffer: " + ReasonOf(error));
      }
    }
    std::uint32_t type = device_.BufferType();
    if (const int error = device_.Call(VIDIOC_STREAMON, &type); error != 0) {
      Refuse(device_.Path(), "starting the stream: " + ReasonOf(error));
    }
  }

  tl::unexpected<CameraFault> Fault(CameraFaultKind kind, const std::string& reason) const {
    return tl::unexpected(CameraFault{kind, device_.Path() + ": " + reason});
  }

  tl::unexpected<CameraFault> FaultOf(int error) const {
    switch (error) {
      case EAGAIN:
        return Fault(CameraFaultKind::kStalled, "no picture");
      case EPIPE:
        return Fault(CameraFaultKind::kEnded, "the stream has ended");
      case ENODEV:
      case ENXIO:
      case EBADF:
        return Fault(CameraFaultKind::kUnplugged, "the camera is gone");
      default:
        break;
    }
    if (FormatHasChanged()) return FormatChanged();
    return Fault(CameraFaultKind::kFailed, std::string("the stream failed: ") + ReasonOf(error));
  }

  tl::unexpected<CameraFault> FormatChanged() const {
    return Fault(CameraFaultKind::kFormatChanged, "the camera changed its format or size");
  }

  bool FormatHasChanged() const {
    v4l2_pix_format format{};
    if (device_.CallWithFormat(VIDIOC_G_FMT, format) != 0) return false;
    return static_cast<int>(format.width) != layout_.width_px ||
           static_cast<int>(format.height) != layout_.height_px ||
           PixelFormatOf(format.pixelformat) != layout_.format;
  }

  bool TakesSourceChange() {
    bool has_changed = false;
    v4l2_event event{};
    while (device_.Call(VIDIOC_DQEVENT, &event) == 0) {
      has_changed = has_changed || event.type == V4L2_EVENT_SOURCE_CHANGE;
      if (event.pending == 0) break;
    }
    return has_changed;
  }

  tl::expected<CapturedBuffer, CameraFault> Dequeue(std::chrono::milliseconds timeout) {
    pollfd wait{device_.Descriptor(), POLLIN | POLLPRI, 0};
    const int ready = poll(&wait, 1, static_cast<int>(timeout.count()));
    if (ready == 0 || (ready < 0 && errno == EINTR)) return FaultOf(EAGAIN);
    if (ready < 0) return FaultOf(errno);
    if ((wait.revents & POLLPRI) != 0 && TakesSourceChange()) return FormatChanged();

    DriverBuffer buffer;
    if (const int error = device_.CallWithBuffer(VIDIOC_DQBUF, buffer); error != 0) {
      return FaultOf(error);
    }
    if (buffer.index >= buffers_.size()) {
      return Fault(CameraFaultKind::kFailed, "the driver gave a buffer that it does not have");
    }
    CapturedBuffer captured;
    captured.bytes = buffers_[buffer.index].Copy(buffer);
    captured.layout = layout_;
    // A loopback device sets the counts of all its pictures to 0 when a reader comes.
    if (buffer.sequence != 0 || !is_loopback_) captured.sequence = buffer.sequence;
    captured.is_damaged = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
    captured.monotonic_time =
        (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC
            ? std::chrono::seconds(buffer.timestamp.tv_sec) +
                  std::chrono::microseconds(buffer.timestamp.tv_usec)
            : ReadClock(CLOCK_MONOTONIC);
    captured.exposure = lock_->Of(buffer.sequence);
    if (layout_.format.coding == PixelCoding::kBayer) {
      captured.development = development_;
    }
    if (const int error = device_.CallWithBuffer(VIDIOC_QBUF, buffer); error != 0) {
      return FaultOf(error);
    }
    return captured;
  }

  V4l2Device device_;
  bool is_loopback_;
  std::string identity_;
  std::optional<RawDevelopment> development_;
  PictureLayout layout_;
  double frames_per_second_ = 0.0;
  std::vector<std::string> notes_;
  std::optional<CameraLock> lock_;  // Once the mode is set.
  std::vector<MappedBuffer> buffers_;
  int frames_to_pass_ = 0;
};

}  // namespace

CameraList ListV4l2Cameras() {
  CameraList list;
  for (int number = 0; number < kMostNumbers; ++number) {
    int error = 0;
    const std::optional<V4l2Device> device = V4l2Device::Open(PathOf(number), error);
    if (error == EACCES || error == EPERM) {
      list.not_permitted.push_back(PathOf(number));
    }
    if (!device) continue;
    const std::optional<v4l2_capability> camera = device->Camera();
    if (!camera) continue;
    const auto* driver = reinterpret_cast<const char*>(camera->driver);
    list.cameras.push_back({device->Path(),
                            CardOf(*camera),
                            IdentityOf(number, *camera),
                            std::string(driver, strnlen(driver, sizeof camera->driver)),
                            device->Modes(),
                            device->Controls()});
  }
  return list;
}

std::unique_ptr<CameraStream> OpenV4l2Camera(const std::string& device,
                                             const CameraRequest& request) {
  int error = 0;
  std::optional<V4l2Device> opened = V4l2Device::Open(device, error);
  if (!opened) Refuse(device, std::string("expected a camera: ") + std::strerror(error));
  const std::optional<v4l2_capability> camera = opened->Camera();
  if (!camera) {
    Refuse(device,
           opened->IsLoopback()
               ? "expected a camera that streams, found a loopback device that no program writes to"
               : "expected a camera that streams, found another device");
  }
  return std::make_unique<V4l2Stream>(std::move(*opened), *camera, request);
}

std::optional<std::string> FindV4l2Camera(const std::string& identity) {
  for (int number = 0; number < kMostNumbers; ++number) {
    int error = 0;
    const std::optional<V4l2Device> device = V4l2Device::Open(PathOf(number), error);
    if (!device) continue;
    const std::optional<v4l2_capability> camera = device->Camera();
    if (!camera) continue;
    // A site may name the port alone.
    if (PortOf(*camera) == identity || IdentityOf(number, *camera) == identity) {
      return device->Path();
    }
  }
  return std::nullopt;
}

std::vector<std::string> ListLoopbackDevices() {
  std::vector<std::string> devices;
  for (int number = 0; number < kMostNumbers; ++number) {
    int error = 0;
    const std::optional<V4l2Device> device = V4l2Device::Open(PathOf(number), error);
    if (device && device->IsLoopback()) devices.push_back(device->Path());
  }
  return devices;
}

}  // namespace pleinair

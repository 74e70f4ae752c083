#include "datasets/camera/libcamera_camera.h"

#include <libcamera/camera.h>
#include <libcamera/camera_manager.h>
#include <libcamera/control_ids.h>
#include <libcamera/framebuffer_allocator.h>
#include <libcamera/logging.h>
#include <libcamera/property_ids.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "datasets/camera/internal/camera_mode.h"
#include "datasets/camera/internal/libcamera_lock.h"
#include "datasets/camera/internal/read_clock.h"

namespace pleinair {
namespace {

namespace controls = libcamera::controls;
using std::chrono::nanoseconds;

constexpr std::string_view kPackedSuffix = "_CSI2P";

[[noreturn]] void Stop(const std::string& device, const std::string& why) {
  throw std::runtime_error(device + ": " + why);
}

// A return value of libcamera: 0, or errno's value below 0.
void Require(const std::string& device, int result, const char* step) {
  if (result >= 0) return;
  const bool is_used = result == -EBUSY || result == -EAGAIN;
  Stop(device,
       fmt::format(
           "{}: {}", step, is_used ? "another program uses the camera" : std::strerror(-result)));
}

// libcamera allows one manager a process, and starting it takes a while: it is kept.
libcamera::CameraManager& Manager() {
  // A manager logs from its construction on.
  struct Silence {
    Silence() {
      if (std::getenv("LIBCAMERA_LOG_FILE") == nullptr) {
        libcamera::logSetTarget(libcamera::LoggingTargetNone);
      }
    }
  };
  struct Running {
    Running() {
      if (const int error = manager.start(); error != 0) {
        throw std::runtime_error(std::string("libcamera does not start: ") + std::strerror(-error));
      }
    }
    ~Running() { manager.stop(); }
    Running(const Running&) = delete;
    Running& operator=(const Running&) = delete;
    Silence silence;
    libcamera::CameraManager manager;
  };
  static Running running;
  return running.manager;
}

// libcamera uses DRM's names of formats, which are ours except for three.
std::optional<PixelFormat> OursOf(const libcamera::PixelFormat& format) {
  std::string name = format.toString();
  if (name == "R8") name = "GREY";
  if (name == "BGR888") name = "RGB24";  // Red is in the lowest byte.
  if (name.ends_with(kPackedSuffix)) name.replace(name.size() - kPackedSuffix.size(), 6, "P");
  return PixelFormatNamed(name);
}

libcamera::PixelFormat TheirsOf(const PixelFormat& format) {
  std::string name = NameOf(format);
  if (format.coding == PixelCoding::kGrey) name = "R8";
  if (format.coding == PixelCoding::kRgb) name = "BGR888";
  if (format.is_packed) name.replace(name.size() - 1, 1, kPackedSuffix);
  return libcamera::PixelFormat::fromString(name);
}

double NumberOf(const libcamera::ControlValue& value) {
  if (value.isArray()) return std::nan("");
  switch (value.type()) {
    case libcamera::ControlTypeBool:
      return value.get<bool>() ? 1.0 : 0.0;
    case libcamera::ControlTypeByte:
      return value.get<std::uint8_t>();
    case libcamera::ControlTypeInteger32:
      return value.get<std::int32_t>();
    case libcamera::ControlTypeInteger64:
      return static_cast<double>(value.get<std::int64_t>());
    case libcamera::ControlTypeFloat:
      return static_cast<double>(value.get<float>());
    default:
      return std::nan("");
  }
}

// Highest first, from the limits of a frame's duration.
std::vector<double> RatesOf(const libcamera::Camera& camera) {
  const auto limits = camera.controls().find(controls::FrameDurationLimits.id());
  if (limits == camera.controls().end()) return {};
  std::vector<double> rates;
  for (const libcamera::ControlValue& end : {limits->second.min(), limits->second.max()}) {
    if (const double duration_us = NumberOf(end); duration_us > 0.0) {
      rates.push_back(1e6 / duration_us);
    }
  }
  return rates;
}

// `wanted` is a size that is listed where the camera supports it, even if it is not a usual one.
void AddModes(libcamera::Camera& camera,
              libcamera::StreamRole role,
              std::optional<libcamera::Size> wanted,
              std::vector<CameraMode>& modes) {
  const auto configuration = camera.generateConfiguration({role});
  if (!configuration || configuration->empty()) return;
  libcamera::StreamConfiguration& stream = configuration->at(0);
  const libcamera::StreamFormats formats = stream.formats();
  for (const libcamera::PixelFormat& theirs : formats.pixelformats()) {
    const std::optional<PixelFormat> format = OursOf(theirs);
    // The other role lists the others.
    if (!format ||
        (format->coding == PixelCoding::kBayer) != (role == libcamera::StreamRole::Raw)) {
      continue;
    }
    std::vector<libcamera::Size> sizes = formats.sizes(theirs);
    if (wanted) sizes.push_back(*wanted);
    for (const libcamera::Size& size : sizes) {
      stream.pixelFormat = theirs;
      stream.size = size;
      // The sizes of a range are usual ones: the pipeline has its own steps.
      if (configuration->validate() == libcamera::CameraConfiguration::Invalid ||
          stream.pixelFormat != theirs) {
        continue;
      }
      const CameraMode mode{*format,
                            static_cast<int>(stream.size.width),
                            static_cast<int>(stream.size.height),
                            RatesOf(camera)};
      const bool is_new = std::none_of(modes.begin(), modes.end(), [&](const CameraMode& other) {
        return other.format == mode.format && other.width_px == mode.width_px &&
               other.height_px == mode.height_px;
      });
      if (is_new) modes.push_back(mode);
    }
  }
}

std::vector<CameraMode> ModesOf(libcamera::Camera& camera,
                                std::optional<libcamera::Size> wanted = {}) {
  std::vector<CameraMode> modes;
  AddModes(camera, libcamera::StreamRole::Viewfinder, wanted, modes);
  AddModes(camera, libcamera::StreamRole::Raw, wanted, modes);
  return modes;
}

std::string UnitOf(const libcamera::ControlId& control) {
  if (control.id() == controls::ExposureTime.id()) return "us";
  if (control.id() == controls::ColourTemperature.id()) return "K";
  return {};
}

// libcamera states no current values: the defaults replace them.
std::vector<CameraControl> ControlsOf(const libcamera::Camera& camera) {
  std::vector<CameraControl> list;
  for (const auto& [control, info] : camera.controls()) {
    const double minimum = NumberOf(info.min());
    const double maximum = NumberOf(info.max());
    if (!(minimum <= maximum)) continue;
    const double stated = NumberOf(info.def());
    const double standard = stated >= minimum && stated <= maximum ? stated : minimum;
    list.push_back(
        {control->name(), minimum, maximum, standard, standard, UnitOf(*control), false});
  }
  std::sort(list.begin(), list.end(), [](const CameraControl& a, const CameraControl& b) {
    return a.name < b.name;
  });
  return list;
}

PictureLayout LayoutOf(const std::string& device, const libcamera::StreamConfiguration& stream) {
  const std::optional<PixelFormat> format = OursOf(stream.pixelFormat);
  if (!format) Stop(device, "libcamera chose a format that cannot be decoded");
  PictureLayout layout{*format,
                       static_cast<int>(stream.size.width),
                       static_cast<int>(stream.size.height),
                       static_cast<int>(stream.stride),
                       {}};
  if (stream.colorSpace) {
    using Space = libcamera::ColorSpace;
    if (stream.colorSpace->ycbcrEncoding == Space::YcbcrEncoding::Rec709) {
      layout.yuv.matrix = YuvMatrix::kBt709;
    } else if (stream.colorSpace->ycbcrEncoding == Space::YcbcrEncoding::Rec2020) {
      layout.yuv.matrix = YuvMatrix::kBt2020;
    }
    layout.yuv.is_full_range = stream.colorSpace->range == Space::Range::Full;
  }
  return layout;
}

// libcamera documents CLOCK_BOOTTIME, and hands on what drivers state, mostly CLOCK_MONOTONIC. The
// two differ after the machine has slept; no picture is of the future.
nanoseconds MonotonicOf(nanoseconds stated) {
  const nanoseconds now = ReadClock(CLOCK_MONOTONIC);
  if (stated <= nanoseconds{0}) return now;
  return stated <= now ? stated : stated - (ReadClock(CLOCK_BOOTTIME) - now);
}

// A picture's memory, shared with the driver; its planes one after the other.
class MappedPlanes {
 public:
  MappedPlanes(const std::string& device, const libcamera::FrameBuffer& buffer) : buffer_(buffer) {
    for (const auto& plane : buffer.planes()) {
      std::size_t& length = Of(plane.fd.get()).length;
      length = std::max<std::size_t>(length, std::size_t{plane.offset} + plane.length);
    }
    for (auto& [descriptor, memory] : memory_) {
      void* start = mmap(nullptr, memory.length, PROT_READ, MAP_SHARED, descriptor, 0);
      if (start == MAP_FAILED) Stop(device, std::string("mmap: ") + std::strerror(errno));
      memory.start = static_cast<const std::byte*>(start);
    }
  }
  ~MappedPlanes() {
    for (auto& [descriptor, memory] : memory_) {
      if (memory.start != nullptr) munmap(const_cast<std::byte*>(memory.start), memory.length);
    }
  }
  MappedPlanes(const MappedPlanes&) = delete;
  MappedPlanes& operator=(const MappedPlanes&) = delete;

  std::vector<std::byte> Copy() {
    std::vector<std::byte> bytes;
    const auto& planes = buffer_.planes();
    const auto used = buffer_.metadata().planes();
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const std::byte* start = Of(planes[i].fd.get()).start + planes[i].offset;
      const std::size_t length =
          i < used.size() ? std::min(used[i].bytesused, planes[i].length) : planes[i].length;
      bytes.insert(bytes.end(), start, start + length);
    }
    return bytes;
  }

 private:
  struct Memory {
    const std::byte* start = nullptr;
    std::size_t length = 0;
  };
  Memory& Of(int descriptor) { return memory_[descriptor]; }

  const libcamera::FrameBuffer& buffer_;
  std::map<int, Memory> memory_;
};

class LibcameraStream final : public CameraStream {
 public:
  LibcameraStream(std::string device,
                  std::shared_ptr<libcamera::Camera> camera,
                  const CameraRequest& request)
      : device_(std::move(device)),
        camera_(std::move(camera)),
        request_(request),
        allocator_(camera_) {
    Require(device_, camera_->acquire(), "opening");
    try {
      Start();
    } catch (...) {
      End();
      throw;
    }
  }
  ~LibcameraStream() override { End(); }

  tl::expected<CapturedBuffer, CameraFault> Next(std::chrono::milliseconds timeout) override {
    libcamera::Request* done = nullptr;
    {
      std::unique_lock lock(mutex_);
      has_news_.wait_for(lock, timeout, [&] { return is_gone_ || !done_.empty(); });
      if (is_gone_) return Fault(CameraFaultKind::kUnplugged, "the camera is gone");
      if (done_.empty()) return Fault(CameraFaultKind::kStalled, "no picture");
      done = done_.front();
      done_.pop_front();
    }
    std::optional<CapturedBuffer> captured;
    if (lock_->Take(done->metadata())) captured = BufferOf(*done);
    done->reuse(libcamera::Request::ReuseBuffers);
    done->controls().merge(lock_->TakeControls());
    if (const int error = camera_->queueRequest(done); error != 0) {
      return Fault(error == -ENODEV ? CameraFaultKind::kUnplugged : CameraFaultKind::kFailed,
                   std::string("the camera takes no more pictures: ") + std::strerror(-error));
    }
    if (captured) return std::move(*captured);
    return Fault(CameraFaultKind::kSettling, "the camera settles");
  }

  const PictureLayout& Layout() const override { return layout_; }
  double FramesPerSecond() const override { return frames_per_second_; }
  const std::string& Identity() const override { return device_; }
  CameraSettings Settings() const override { return lock_->Settings(); }
  std::vector<std::string> TakeNotes() override { return lock_->TakeNotes(); }

 private:
  void Start() {
    std::optional<libcamera::Size> wanted;
    if (request_.width_px && request_.height_px) {
      wanted.emplace(static_cast<unsigned>(*request_.width_px),
                     static_cast<unsigned>(*request_.height_px));
    }
    const CameraMode mode = ChooseMode(device_, ModesOf(*camera_, wanted), request_);
    configuration_ = camera_->generateConfiguration({mode.format.coding == PixelCoding::kBayer
                                                         ? libcamera::StreamRole::Raw
                                                         : libcamera::StreamRole::Viewfinder});
    libcamera::StreamConfiguration& stream = configuration_->at(0);
    stream.pixelFormat = TheirsOf(mode.format);
    stream.size = {static_cast<unsigned>(mode.width_px), static_cast<unsigned>(mode.height_px)};
    if (configuration_->validate() == libcamera::CameraConfiguration::Invalid) {
      Stop(device_, "libcamera refuses the format");
    }
    Require(device_, camera_->configure(configuration_.get()), "setting the format");
    layout_ = LayoutOf(device_, stream);

    Require(device_, allocator_.allocate(stream.stream()), "asking for buffers");
    for (const auto& buffer : allocator_.buffers(stream.stream())) {
      memory_.try_emplace(buffer.get(), device_, *buffer);
      requests_.push_back(camera_->createRequest());
      if (!requests_.back()) Stop(device_, "libcamera makes no request");
      Require(device_, requests_.back()->addBuffer(stream.stream(), buffer.get()), "a buffer");
    }
    lock_.emplace(device_, camera_->controls(), request_, static_cast<int>(requests_.size()));

    libcamera::ControlList start = lock_->StartControls();
    SetRate(mode, start);
    camera_->requestCompleted.connect(this, &LibcameraStream::OnCompleted);
    camera_->disconnected.connect(this, &LibcameraStream::OnGone);
    Require(device_, camera_->start(&start), "starting the stream");
    for (const auto& request : requests_) {
      Require(device_, camera_->queueRequest(request.get()), "a request");
    }
  }

  void SetRate(const CameraMode& mode, libcamera::ControlList& start) {
    if (mode.frames_per_second.empty()) return;
    frames_per_second_ =
        std::clamp(request_.frames_per_second.value_or(kUsualFramesPerSecond),
                   *std::min_element(mode.frames_per_second.begin(), mode.frames_per_second.end()),
                   *std::max_element(mode.frames_per_second.begin(), mode.frames_per_second.end()));
    const auto duration_us = static_cast<std::int64_t>(std::llround(1e6 / frames_per_second_));
    const std::array<std::int64_t, 2> limits{duration_us, duration_us};
    start.set(controls::FrameDurationLimits, libcamera::Span<const std::int64_t, 2>(limits));
  }

  void End() {
    camera_->stop();  // Hands all requests back.
    camera_->requestCompleted.disconnect(this);
    camera_->disconnected.disconnect(this);
    requests_.clear();
    memory_.clear();
    if (configuration_) {
      for (libcamera::StreamConfiguration& stream : *configuration_) {
        if (stream.stream() != nullptr) allocator_.free(stream.stream());
      }
    }
    camera_->release();
  }

  // Both in libcamera's thread.
  void OnCompleted(libcamera::Request* request) {
    if (request->status() == libcamera::Request::RequestCancelled) return;
    const std::lock_guard lock(mutex_);
    done_.push_back(request);
    has_news_.notify_one();
  }
  void OnGone() {
    const std::lock_guard lock(mutex_);
    is_gone_ = true;
    has_news_.notify_one();
  }

  CapturedBuffer BufferOf(libcamera::Request& request) {
    const libcamera::FrameBuffer* buffer = request.buffers().begin()->second;
    const libcamera::FrameMetadata& frame = buffer->metadata();
    const libcamera::ControlList& metadata = request.metadata();
    CapturedBuffer captured;
    captured.bytes = memory_.at(buffer).Copy();
    captured.layout = layout_;
    captured.sequence = frame.sequence;
    captured.monotonic_time =
        MonotonicOf(nanoseconds(metadata.get(controls::SensorTimestamp)
                                    .value_or(static_cast<std::int64_t>(frame.timestamp))));
    captured.is_damaged = frame.status != libcamera::FrameMetadata::FrameSuccess;
    captured.exposure = lock_->Exposure();
    if (layout_.format.coding == PixelCoding::kBayer) {
      captured.development =
          request_.development.value_or(DevelopmentOf(metadata, layout_.format.bits));
    }
    return captured;
  }

  tl::unexpected<CameraFault> Fault(CameraFaultKind kind, const std::string& reason) const {
    return tl::unexpected(CameraFault{kind, device_ + ": " + reason});
  }

  std::string device_;
  std::shared_ptr<libcamera::Camera> camera_;
  CameraRequest request_;
  libcamera::FrameBufferAllocator allocator_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  PictureLayout layout_;
  double frames_per_second_ = 0.0;
  std::map<const libcamera::FrameBuffer*, MappedPlanes> memory_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;
  std::optional<LibcameraLock> lock_;

  std::mutex mutex_;  // Guards the state that libcamera's thread changes:
  std::condition_variable has_news_;
  std::deque<libcamera::Request*> done_;
  bool is_gone_ = false;
};

std::string IdOf(const std::string& device) {
  return device.substr(std::string_view(kLibcameraPrefix).size());
}

}  // namespace

std::string LibcameraVersion() { return libcamera::CameraManager::version(); }

CameraList ListLibcameraCameras() {
  CameraList list;
  try {
    for (const std::shared_ptr<libcamera::Camera>& camera : Manager().cameras()) {
      const std::string device = kLibcameraPrefix + camera->id();
      list.cameras.push_back(
          {device,
           camera->properties().get(libcamera::properties::Model).value_or(camera->id()),
           device,
           "libcamera " + LibcameraVersion(),
           ModesOf(*camera),
           ControlsOf(*camera)});
    }
  } catch (const std::runtime_error& error) {
    list.libcamera_failure = error.what();
  }
  return list;
}

std::unique_ptr<CameraStream> OpenLibcameraCamera(const std::string& device,
                                                  const CameraRequest& request) {
  const std::shared_ptr<libcamera::Camera> camera = Manager().get(IdOf(device));
  if (!camera) {
    Stop(device, "expected a camera of libcamera's, as `pleinair cameras` lists them");
  }
  return std::make_unique<LibcameraStream>(device, camera, request);
}

std::optional<std::string> FindLibcameraCamera(const std::string& identity) {
  if (!Manager().get(IdOf(identity))) return std::nullopt;
  return identity;
}

}  // namespace pleinair

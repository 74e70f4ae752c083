#include "apps/camera_stand_in/shim/device_calls.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "apps/camera_stand_in/device_state.h"
#include "apps/camera_stand_in/shim/controls.h"
#include "apps/camera_stand_in/shim/handles.h"
#include "apps/camera_stand_in/shim/renderer.h"
#include "apps/camera_stand_in/shim/stream.h"

namespace pleinair::stand_in {
namespace {

template <std::size_t kLength>
void CopyText(unsigned char (&to)[kLength], const char* text) {
  std::snprintf(reinterpret_cast<char*>(to), kLength, "%s", text);
}

std::uint32_t BufferType(const DeviceState& state) {
  return state.is_multi_planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

int QueryCapabilities(const DeviceState& state, v4l2_capability& answer) {
  answer = {};
  CopyText(answer.driver, "pleinair");
  CopyText(answer.card, "pleinair stand-in");
  char bus[sizeof answer.bus_info];
  std::snprintf(bus, sizeof bus, "stand-in:%d", state.number_given);
  CopyText(answer.bus_info, bus);
  answer.version = 0x060100;
  answer.device_caps =
      (state.is_multi_planar ? V4L2_CAP_VIDEO_CAPTURE_MPLANE : V4L2_CAP_VIDEO_CAPTURE) |
      V4L2_CAP_STREAMING | V4L2_CAP_EXT_PIX_FORMAT;
  answer.capabilities = answer.device_caps | V4L2_CAP_DEVICE_CAPS;
  return 0;
}

int EnumerateFormats(const DeviceState& state, v4l2_fmtdesc& query) {
  const auto formats = PixelFormats();
  if (query.type != BufferType(state) || query.index >= formats.size()) return EINVAL;
  const PixelFormatInfo& info = formats[query.index];
  const v4l2_fmtdesc asked = query;
  query = {};
  query.index = asked.index;
  query.type = asked.type;
  query.pixelformat = info.pixel_format;
  query.flags = info.pixel_format == V4L2_PIX_FMT_MJPEG ? V4L2_FMT_FLAG_COMPRESSED : 0u;
  CopyText(query.description, info.description);
  return 0;
}

int EnumerateSizes(const DeviceState& state, v4l2_frmsizeenum& query) {
  if (!HasPixelFormat(query.pixel_format)) return EINVAL;
  std::uint32_t index = 0;
  for (int i = 0; i < state.size_count; ++i) {
    if (!Fits(query.pixel_format, state.sizes[i]) || index++ != query.index) continue;
    query.type = V4L2_FRMSIZE_TYPE_DISCRETE;
    query.discrete.width = static_cast<std::uint32_t>(state.sizes[i].width);
    query.discrete.height = static_cast<std::uint32_t>(state.sizes[i].height);
    return 0;
  }
  return EINVAL;
}

int EnumerateIntervals(const DeviceState& state, v4l2_frmivalenum& query) {
  const Size size{static_cast<int>(query.width), static_cast<int>(query.height)};
  const auto* const end = state.sizes.data() + state.size_count;
  if (!HasPixelFormat(query.pixel_format) || !Fits(query.pixel_format, size) ||
      std::find(state.sizes.data(), end, size) == end ||
      query.index >= static_cast<std::uint32_t>(state.interval_count)) {
    return EINVAL;
  }
  query.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  query.discrete = {state.intervals[query.index].numerator,
                    state.intervals[query.index].denominator};
  return 0;
}

// The nearest that the device can do.
template <typename WantedFormat>
Format Nearest(const DeviceState& state, const WantedFormat& wanted) {
  Format format = state.default_format;
  if (HasPixelFormat(wanted.pixelformat)) format.pixel_format = wanted.pixelformat;
  long least = -1;
  for (int i = 0; i < state.size_count; ++i) {
    const Size size = state.sizes[i];
    if (!Fits(format.pixel_format, size)) continue;
    const long distance = std::labs(static_cast<long>(wanted.width) - size.width) +
                          std::labs(static_cast<long>(wanted.height) - size.height);
    if (least >= 0 && distance >= least) continue;
    least = distance;
    format.size = size;
  }
  return format;
}

void DescribeFormat(const DeviceState& state, const Format& format, v4l2_pix_format& answer) {
  answer = {};
  answer.width = static_cast<std::uint32_t>(format.size.width);
  answer.height = static_cast<std::uint32_t>(format.size.height);
  answer.pixelformat = format.pixel_format;
  answer.field = V4L2_FIELD_NONE;
  answer.bytesperline = static_cast<std::uint32_t>(BytesPerLine(format));
  answer.sizeimage = static_cast<std::uint32_t>(BufferBytes(format));
  answer.priv = V4L2_PIX_FMT_PRIV_MAGIC;
  answer.colorspace = V4L2_COLORSPACE_SRGB;
  answer.xfer_func = V4L2_XFER_FUNC_SRGB;
  answer.ycbcr_enc = V4L2_YCBCR_ENC_601;
  answer.quantization = V4L2_QUANTIZATION_FULL_RANGE;
  if (RawBits(format.pixel_format) != 0) {
    answer.colorspace = V4L2_COLORSPACE_RAW;
    answer.xfer_func = V4L2_XFER_FUNC_NONE;
  } else if (format.pixel_format == V4L2_PIX_FMT_MJPEG) {
    answer.colorspace = V4L2_COLORSPACE_JPEG;
  } else if (format.pixel_format == V4L2_PIX_FMT_YUYV || format.pixel_format == V4L2_PIX_FMT_NV12) {
    answer.ycbcr_enc = state.ycbcr_encoding;
    answer.quantization = state.quantization;
  }
}

// Into the part of `answer` that the device's type of buffers has.
void DescribeFormat(const DeviceState& state, const Format& format, v4l2_format& answer) {
  v4l2_pix_format described{};
  DescribeFormat(state, format, described);
  if (!state.is_multi_planar) {
    answer.fmt.pix = described;
    return;
  }
  answer.fmt.pix_mp = {};
  v4l2_pix_format_mplane& planes = answer.fmt.pix_mp;
  planes.width = described.width;
  planes.height = described.height;
  planes.pixelformat = described.pixelformat;
  planes.field = described.field;
  planes.colorspace = described.colorspace;
  planes.num_planes = 1;
  planes.plane_fmt[0].bytesperline = described.bytesperline;
  planes.plane_fmt[0].sizeimage = described.sizeimage;
  planes.ycbcr_enc = static_cast<__u8>(described.ycbcr_enc);
  planes.quantization = static_cast<__u8>(described.quantization);
  planes.xfer_func = static_cast<__u8>(described.xfer_func);
}

int GetFormat(const DeviceState& state, v4l2_format& answer) {
  if (answer.type != BufferType(state)) return EINVAL;
  DescribeFormat(state, state.format, answer);
  return 0;
}

int SetFormat(DeviceState& state, Handle& handle, bool try_only, v4l2_format& wanted) {
  if (wanted.type != BufferType(state)) return EINVAL;
  const Format format =
      state.is_multi_planar ? Nearest(state, wanted.fmt.pix_mp) : Nearest(state, wanted.fmt.pix);
  if (!try_only) {
    if (handle.HasBuffers() || !handle.OwnsDevice()) return EBUSY;
    std::uint32_t none = 0;
    handle.Allocate(none);  // Only a handle with buffers keeps the device.
    if (format.size != state.format.size) state.size_changed = false;
    state.format = format;
  }
  DescribeFormat(state, format, wanted);
  return 0;
}

int GetParameters(const DeviceState& state, v4l2_streamparm& answer) {
  if (answer.type != BufferType(state)) return EINVAL;
  answer.parm.capture = {};
  answer.parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
  answer.parm.capture.timeperframe = {state.interval.numerator, state.interval.denominator};
  answer.parm.capture.readbuffers = 2;
  return 0;
}

int SetParameters(DeviceState& state, const Handle& handle, v4l2_streamparm& wanted) {
  if (wanted.type != BufferType(state)) return EINVAL;
  if (handle.IsStreaming()) return EBUSY;
  const v4l2_fract asked = wanted.parm.capture.timeperframe;
  state.interval = state.default_interval;
  if (asked.numerator != 0 && asked.denominator != 0) {
    const double seconds = static_cast<double>(asked.numerator) / asked.denominator;
    const auto distance = [&](const Interval& interval) {
      const double offered = static_cast<double>(interval.numerator) / interval.denominator;
      return offered > seconds ? offered / seconds : seconds / offered;
    };
    state.interval = *std::min_element(
        state.intervals.begin(),
        state.intervals.begin() + state.interval_count,
        [&](const Interval& a, const Interval& b) { return distance(a) < distance(b); });
  }
  return GetParameters(state, wanted);
}

int RequestBuffers(const DeviceState& state, Handle& handle, v4l2_requestbuffers& request) {
  if (request.type != BufferType(state) || request.memory != V4L2_MEMORY_MMAP) {
    return EINVAL;
  }
  request.capabilities = V4L2_BUF_CAP_SUPPORTS_MMAP | V4L2_BUF_CAP_SUPPORTS_ORPHANED_BUFS;
  return handle.Allocate(request.count);
}

int EnumerateInput(v4l2_input& query) {
  if (query.index != 0) return EINVAL;
  query = {};
  CopyText(query.name, "Camera 1");
  query.type = V4L2_INPUT_TYPE_CAMERA;
  return 0;
}

int QueryOldControl(const DeviceState& state, v4l2_queryctrl& query) {
  v4l2_query_ext_ctrl extended{};
  extended.id = query.id;
  if (const int error = QueryControl(state, extended)) return error;
  query = {};
  query.id = extended.id;
  query.type = extended.type;
  CopyText(query.name, extended.name);
  query.minimum = static_cast<std::int32_t>(extended.minimum);
  query.maximum = static_cast<std::int32_t>(extended.maximum);
  query.step = static_cast<std::int32_t>(extended.step);
  query.default_value = static_cast<std::int32_t>(extended.default_value);
  query.flags = extended.flags;
  return 0;
}

int Subscribe(Handle& handle, const v4l2_event_subscription& subscription, bool subscribe) {
  const bool all = !subscribe && subscription.type == V4L2_EVENT_ALL;
  if (!all && subscription.type != V4L2_EVENT_SOURCE_CHANGE) return EINVAL;
  handle.wants_source_changes = subscribe;
  return 0;
}

bool IsBlocking(int fd) { return (fcntl(fd, F_GETFL) & O_NONBLOCK) == 0; }

template <typename T>
T& As(void* argument) {
  return *static_cast<T*>(argument);
}

// A handle knows single-planar buffers alone: calls `call` with one that stands for the program's,
// which then gets what it was filled with.
template <typename BufferCall>
int WithBuffer(const DeviceState& state, void* argument, const BufferCall& call) {
  auto& asked = As<v4l2_buffer>(argument);
  if (!state.is_multi_planar) return call(asked);
  if (asked.type != BufferType(state) || asked.m.planes == nullptr || asked.length < 1) {
    return EINVAL;
  }
  v4l2_buffer single = asked;
  single.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = call(single)) return error;
  v4l2_plane* const planes = asked.m.planes;
  planes[0] = {};
  planes[0].bytesused = single.bytesused;
  planes[0].length = single.length;
  planes[0].m.mem_offset = single.m.offset;
  asked = single;
  asked.type = BufferType(state);
  asked.m.planes = planes;
  asked.length = 1;
  asked.bytesused = 0;
  return 0;
}

// Everything but the waiting of DQBUF and DQEVENT.
int Call(DeviceState& state, Handle& handle, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP:
      return QueryCapabilities(state, As<v4l2_capability>(argument));
    case VIDIOC_ENUM_FMT:
      return EnumerateFormats(state, As<v4l2_fmtdesc>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return EnumerateSizes(state, As<v4l2_frmsizeenum>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return EnumerateIntervals(state, As<v4l2_frmivalenum>(argument));
    case VIDIOC_G_FMT:
      return GetFormat(state, As<v4l2_format>(argument));
    case VIDIOC_S_FMT:
      return SetFormat(state, handle, false, As<v4l2_format>(argument));
    case VIDIOC_TRY_FMT:
      return SetFormat(state, handle, true, As<v4l2_format>(argument));
    case VIDIOC_G_PARM:
      return GetParameters(state, As<v4l2_streamparm>(argument));
    case VIDIOC_S_PARM:
      return SetParameters(state, handle, As<v4l2_streamparm>(argument));
    case VIDIOC_REQBUFS:
      return RequestBuffers(state, handle, As<v4l2_requestbuffers>(argument));
    case VIDIOC_QUERYBUF:
      return WithBuffer(state, argument, [&](v4l2_buffer& one) { return handle.Describe(one); });
    case VIDIOC_QBUF:
      return WithBuffer(state, argument, [&](v4l2_buffer& one) { return handle.Queue(one); });
    case VIDIOC_STREAMON:
      return As<std::uint32_t>(argument) == BufferType(state) ? handle.Start() : EINVAL;
    case VIDIOC_STREAMOFF:
      return As<std::uint32_t>(argument) == BufferType(state) ? handle.Stop() : EINVAL;
    case VIDIOC_ENUMINPUT:
      return EnumerateInput(As<v4l2_input>(argument));
    case VIDIOC_G_INPUT:
      As<int>(argument) = 0;
      return 0;
    case VIDIOC_S_INPUT:
      return As<int>(argument) == 0 ? 0 : EINVAL;
    case VIDIOC_G_PRIORITY:
      As<std::uint32_t>(argument) = state.priority;
      return 0;
    case VIDIOC_S_PRIORITY:
      if (As<std::uint32_t>(argument) > V4L2_PRIORITY_RECORD) return EINVAL;
      state.priority = As<std::uint32_t>(argument);
      return 0;
    case VIDIOC_QUERYCTRL:
      return QueryOldControl(state, As<v4l2_queryctrl>(argument));
    case VIDIOC_QUERY_EXT_CTRL:
      return QueryControl(state, As<v4l2_query_ext_ctrl>(argument));
    case VIDIOC_QUERYMENU:
      return QueryMenu(As<v4l2_querymenu>(argument));
    case VIDIOC_G_CTRL:
      return GetControl(state, As<v4l2_control>(argument));
    case VIDIOC_S_CTRL:
      return SetControl(state, As<v4l2_control>(argument));
    case VIDIOC_G_EXT_CTRLS:
      return GetControls(state, As<v4l2_ext_controls>(argument));
    case VIDIOC_S_EXT_CTRLS:
      return SetControls(state, false, As<v4l2_ext_controls>(argument));
    case VIDIOC_TRY_EXT_CTRLS:
      return SetControls(state, true, As<v4l2_ext_controls>(argument));
    case VIDIOC_SUBSCRIBE_EVENT:
      return Subscribe(handle, As<v4l2_event_subscription>(argument), true);
    case VIDIOC_UNSUBSCRIBE_EVENT:
      return Subscribe(handle, As<v4l2_event_subscription>(argument), false);
    case VIDIOC_DQEVENT:
      return handle.NextEvent(As<v4l2_event>(argument));
    default:
      return ENOTTY;
  }
}

// Waits without the lock until something may have changed.
void WaitFor(int fd) {
  pollfd one{fd, POLLIN, 0};
  syscall(SYS_ppoll, &one, 1, nullptr, nullptr, 0);
}

int Refuse(int error) {
  errno = error;
  return -1;
}

}  // namespace

int OpenDevice(DeviceState& state, int flags) {
  const StateLock lock(state);
  if (MonotonicNs() < state.absent_until_ns) return Refuse(ENODEV);
  const int nonblock = (flags & O_NONBLOCK) != 0 ? TFD_NONBLOCK : 0;
  const int cloexec = (flags & O_CLOEXEC) != 0 ? TFD_CLOEXEC : 0;
  const int pictures_fd =
      static_cast<int>(syscall(SYS_openat, AT_FDCWD, state.pictures_path, O_RDONLY | O_CLOEXEC));
  if (pictures_fd < 0) return Refuse(ENODEV);  // The stand-in's program has ended.
  const int timer_fd = timerfd_create(CLOCK_MONOTONIC, nonblock | cloexec);
  const int event_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (timer_fd < 0 || event_fd < 0) {
    const int error = errno;
    for (const int fd : {pictures_fd, timer_fd, event_fd}) {
      if (fd >= 0) syscall(SYS_close, fd);
    }
    return Refuse(error);
  }
  AddHandle(timer_fd, std::make_shared<Handle>(state, timer_fd, event_fd, pictures_fd));
  return timer_fd;
}

int CallDevice(DeviceState& state, int fd, unsigned long request, void* argument) {
  request &= 0xffffffffu;  // Callers that keep it in an int extend its sign.
  const bool blocking = IsBlocking(fd);
  for (;;) {
    std::shared_ptr<Handle> handle;
    Capture capture;
    int error = 0;
    {
      const StateLock lock(state);
      handle = FindHandle(fd);
      if (handle == nullptr) return Refuse(EBADF);
      handle->Advance();
      if (handle->IsGone()) {
        error = ENODEV;
      } else if (request == VIDIOC_DQBUF) {
        error = WithBuffer(
            state, argument, [&](v4l2_buffer& one) { return handle->Dequeue(one, capture); });
      } else {
        error = Call(state, *handle, request, argument);
      }
    }
    if (error == 0 && request == VIDIOC_DQBUF) {
      auto& filled = As<v4l2_buffer>(argument);
      const std::uint32_t bytes = handle->Render(capture, filled.flags);
      (state.is_multi_planar ? filled.m.planes[0].bytesused : filled.bytesused) = bytes;
    }
    if (error == 0) return 0;
    const bool waits_for_buffer = request == VIDIOC_DQBUF && error == EAGAIN;
    const bool waits_for_event = request == VIDIOC_DQEVENT && error == ENOENT;
    if (!blocking || !(waits_for_buffer || waits_for_event)) return Refuse(error);
    WaitFor(waits_for_buffer ? fd : handle->EventFd());
  }
}

}  // namespace pleinair::stand_in

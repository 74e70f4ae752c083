#include "apps/camera_stand_in/shim/stream.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <limits>
#include <utility>

#include "apps/camera_stand_in/shim/controls.h"
#include "apps/camera_stand_in/shim/handles.h"

namespace pleinair::stand_in {
namespace {

constexpr std::uint32_t kMaxBuffers = 32;
constexpr int kDroppedByFault = 5;
constexpr std::int64_t kStallNs = 3 * kSecondNs;
constexpr std::int64_t kAbsenceNs = kSecondNs;
constexpr std::int64_t kTimeBackNs = kSecondNs;
constexpr std::int64_t kClockStepNs = 3600 * kSecondNs;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr int kMaxNumber = 255;
constexpr std::size_t kMaxEvents = 4;

void CloseFd(int fd) {
  if (fd >= 0) syscall(SYS_close, fd);
}

bool IsOfControls(const Fault& fault) {
  return fault.kind == FaultKind::kControlRefused || fault.kind == FaultKind::kControlClamped;
}
bool EndsStream(const Fault& fault) {
  return fault.kind == FaultKind::kUnplug || fault.kind == FaultKind::kUnplugRenumber ||
         fault.kind == FaultKind::kFormatChange;
}

bool StepsClock(const Fault& fault) {
  return fault.kind == FaultKind::kClockBack || fault.kind == FaultKind::kClockForward;
}

// Leaves a JPEG file's headers, and scrambles what they describe.
void Damage(std::span<std::uint8_t> bytes) {
  std::uint32_t noise = 1;
  for (std::size_t i = bytes.size() / 4; i < bytes.size() / 2; ++i) {
    noise = noise * 1664525u + 1013904223u;
    bytes[i] = static_cast<std::uint8_t>(noise >> 24);
  }
}

}  // namespace

std::int64_t MonotonicNs() {
  timespec now{};
  syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecondNs + now.tv_nsec;
}

Handle::Handle(DeviceState& state, int timer_fd, int event_fd, int pictures_fd)
    : state_(state),
      timer_fd_(fcntl(timer_fd, F_DUPFD_CLOEXEC, 0)),
      event_fd_(event_fd),
      pictures_fd_(pictures_fd),
      plug_count_(state.plug_count),
      renderer_(state, pictures_fd) {
  Arm();
}

Handle::~Handle() {
  Release();
  CloseFd(timer_fd_);
  CloseFd(event_fd_);
  CloseFd(pictures_fd_);
}

bool Handle::OwnsDevice() {
  if (owner_fd_ >= 0) return true;
  owner_fd_ = OpenSharedBlock();
  struct flock lock {};
  lock.l_type = F_WRLCK;
  if (owner_fd_ >= 0 && fcntl(owner_fd_, F_OFD_SETLK, &lock) == 0) return true;
  CloseFd(owner_fd_);
  owner_fd_ = -1;
  return false;
}

void Handle::Release() {
  if (is_streaming_) state_.is_streaming = false;
  is_streaming_ = has_failed_ = has_ended_ = false;
  queued_.clear();
  done_.clear();
  buffers_.clear();
  const std::lock_guard lock(rendering_);
  if (!memory_.empty()) munmap(memory_.data(), memory_.size());
  memory_ = {};
  CloseFd(buffers_fd_);
  buffers_fd_ = -1;
  CloseFd(owner_fd_);
  owner_fd_ = -1;
}

int Handle::Allocate(std::uint32_t& count) {
  if (is_streaming_ || !OwnsDevice()) return EBUSY;
  Release();
  if (count == 0) return 0;
  count = std::clamp(count, 2u, kMaxBuffers);
  if (!OwnsDevice()) return EBUSY;
  const std::lock_guard lock(rendering_);
  format_ = state_.format;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  stride_ = (BufferBytes(format_) + page - 1) / page * page;
  const std::size_t bytes = stride_ * count;
  buffers_fd_ = static_cast<int>(syscall(SYS_memfd_create, "camera buffers", MFD_CLOEXEC));
  void* memory = MAP_FAILED;
  if (buffers_fd_ >= 0 && ftruncate(buffers_fd_, static_cast<off_t>(bytes)) == 0) {
    memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, buffers_fd_, 0);
  }
  if (memory == MAP_FAILED) return ENOMEM;  // The next call that allocates releases the file.
  memory_ = {static_cast<std::uint8_t*>(memory), bytes};
  buffers_.assign(count, {});
  return 0;
}

int Handle::Describe(v4l2_buffer& buffer) const {
  if (buffer.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || buffer.index >= buffers_.size()) return EINVAL;
  const Buffer& described = buffers_[buffer.index];
  buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE |
                 (described.is_queued ? V4L2_BUF_FLAG_QUEUED : 0u) |
                 (described.is_done ? V4L2_BUF_FLAG_DONE : 0u);
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.field = V4L2_FIELD_NONE;
  buffer.m.offset = static_cast<std::uint32_t>(stride_ * buffer.index);
  buffer.length = static_cast<std::uint32_t>(BufferBytes(format_));
  buffer.bytesused = 0;
  return 0;
}

int Handle::Queue(v4l2_buffer& buffer) {
  if (buffer.memory != V4L2_MEMORY_MMAP) return EINVAL;
  if (const int error = Describe(buffer)) return error;
  Buffer& queued = buffers_[buffer.index];
  if (queued.is_queued || queued.is_done) return EINVAL;
  if (has_failed_) return EIO;
  queued.is_queued = true;
  queued_.push_back(buffer.index);
  Describe(buffer);
  Advance();  // The last picture may have waited for it.
  return 0;
}

int Handle::Start() {
  if (buffers_.empty()) return EINVAL;
  if (is_streaming_) return 0;
  const std::int64_t now = MonotonicNs();
  is_streaming_ = state_.is_streaming = true;
  has_failed_ = has_ended_ = false;
  if (state_.pictures_to_play > 0 && state_.picture >= state_.pictures_to_play) state_.picture = 0;
  base_ns_ = now;
  tick_ = 0;
  base_ns_ = std::max(now + TickNs(1) - base_ns_, state_.stalled_until_ns);
  last_time_ns_ = base_ns_;
  Plan();
  if (!state_.clock_is_set) {
    state_.clock_is_set = true;
    state_.realtime_minus_monotonic_ns = state_.first_utc_ns - TickNs(tick_);
  }
  Advance();
  return 0;
}

int Handle::Stop() {
  if (is_streaming_) state_.is_streaming = false;
  is_streaming_ = has_failed_ = has_ended_ = false;
  queued_.clear();
  done_.clear();
  buffers_.assign(buffers_.size(), {});
  Arm();
  return 0;
}

std::int64_t Handle::TickNs(std::int64_t tick) const {
  // Whole groups of `denominator` ticks last whole seconds: no product leaves 64 bits.
  const std::int64_t numerator = state_.interval.numerator;
  const std::int64_t denominator = state_.interval.denominator;
  return base_ns_ + tick / denominator * numerator * kSecondNs +
         tick % denominator * numerator * kSecondNs / denominator;
}

// Lets pictures pass without a buffer.
void Handle::Skip(int ticks) {
  for (int i = 0; i < ticks; ++i) {
    if (state_.pictures_to_play > 0 && state_.picture + 1 >= state_.pictures_to_play) return;
    state_.stream_ns += TickNs(tick_ + 1) - TickNs(tick_);
    ++tick_;
    ++state_.frame;
    ++state_.picture;
  }
}

// Decides what the next tick brings. Faults that only move it happen here.
void Handle::Plan() {
  next_ = {Next::Kind::kPicture, std::exchange(unseen_, nullptr)};
  if (state_.stalled_until_ns == kNever) next_.kind = Next::Kind::kNothing;
  while (state_.next_fault < state_.fault_count && next_.kind == Next::Kind::kPicture &&
         next_.fault == nullptr) {
    Fault& fault = state_.faults[static_cast<std::size_t>(state_.next_fault)];
    if (fault.at > state_.FaultClock()) break;
    if (EndsStream(fault)) {
      next_ = {
          fault.kind == FaultKind::kFormatChange ? Next::Kind::kSourceChange : Next::Kind::kUnplug,
          &fault};
      break;
    }
    ++state_.next_fault;
    if (IsOfControls(fault)) continue;
    fault.struck = true;
    if (fault.kind == FaultKind::kDrop) {
      Skip(kDroppedByFault);
    } else if (fault.kind == FaultKind::kStall) {
      base_ns_ += kStallNs;
      state_.stream_ns += kStallNs;
      state_.stalled_until_ns = TickNs(tick_);
    } else if (fault.kind == FaultKind::kStallForever) {
      state_.stalled_until_ns = kNever;
      next_.kind = Next::Kind::kNothing;
    } else {
      next_.fault = &fault;
    }
  }
}

void Handle::Advance() {
  const std::int64_t now = MonotonicNs();
  while (is_streaming_ && !has_failed_ && !has_ended_ && !IsGone() &&
         next_.kind != Next::Kind::kNothing && TickNs(tick_) <= now) {
    if (!Do()) break;
    if (is_streaming_ && !has_failed_ && !has_ended_ && !IsGone()) Plan();
  }
  Arm();
}

// Returns whether the tick is over.
bool Handle::Do() {
  if (next_.kind == Next::Kind::kPicture) return DoPicture();
  Fault& fault = *next_.fault;
  fault.struck = true;
  ++state_.next_fault;
  fault.kind == FaultKind::kFormatChange ? ChangeSize()
                                         : Unplug(fault.kind == FaultKind::kUnplugRenumber);
  return true;
}

bool Handle::DoPicture() {
  const bool is_last = state_.pictures_to_play > 0 && state_.picture + 1 >= state_.pictures_to_play;
  if (is_last && queued_.empty()) return false;  // It waits, so that the stream has an end.
  const std::int64_t time_ns = TickNs(tick_);
  AdvanceGains(state_);
  if (next_.fault != nullptr && StepsClock(*next_.fault)) {
    state_.realtime_minus_monotonic_ns +=
        next_.fault->kind == FaultKind::kClockBack ? -kClockStepNs : kClockStepNs;
    next_.fault = nullptr;
  }
  Capture capture{.shot = {static_cast<int>(state_.picture % state_.picture_count), state_.gains},
                  .sequence = static_cast<std::uint32_t>(tick_),
                  .time_ns = time_ns,
                  .is_last = is_last};
  if (next_.fault != nullptr) {
    switch (next_.fault->kind) {
      case FaultKind::kTruncate:
        capture.is_short = true;
        break;
      case FaultKind::kCorrupt:
        // Every other time the picture is damaged and the driver has not noticed.
        capture.is_damaged =
            format_.pixel_format == V4L2_PIX_FMT_MJPEG && state_.corrupt_count++ % 2 == 0;
        capture.has_error = !capture.is_damaged;
        break;
      case FaultKind::kTimeRepeat:
        capture.time_ns = last_time_ns_;
        break;
      case FaultKind::kTimeBack:
        capture.time_ns = last_time_ns_ - kTimeBackNs;
        break;
      default:
        break;
    }
  }
  last_time_ns_ = time_ns;
  if (queued_.empty()) {
    unseen_ = next_.fault;
  } else {
    capture.buffer = queued_.front();
    queued_.pop_front();
    buffers_[capture.buffer] = {.is_queued = false, .is_done = true};
    done_.push_back(capture);
    has_ended_ = is_last;
  }
  state_.stream_ns += TickNs(tick_ + 1) - time_ns;
  ++tick_;
  ++state_.frame;
  ++state_.picture;
  return true;
}

void Handle::Unplug(bool renumber) {
  const std::int64_t now = TickNs(tick_);
  ++state_.plug_count;
  state_.absent_until_ns = now + kAbsenceNs;
  if (renumber) state_.number = state_.number < kMaxNumber ? state_.number + 1 : 0;
  state_.format = state_.default_format;
  state_.interval = state_.default_interval;
  state_.size_changed = false;
  state_.is_streaming = false;
  ResetControls(state_);
}

void Handle::ChangeSize() {
  has_failed_ = true;
  if (state_.size_changed) {
    state_.format.size = state_.size_before_change;
  } else {
    state_.size_before_change = state_.format.size;
    // The next size of the list that the format can have.
    const auto* const begin = state_.sizes.data();
    const auto* const end = begin + state_.size_count;
    const auto* size = std::find(begin, end, state_.format.size);
    do {
      size = size + 1 >= end ? begin : size + 1;
    } while (!Fits(state_.format.pixel_format, *size));
    state_.format.size = *size;
  }
  state_.size_changed = !state_.size_changed;
  for (const std::shared_ptr<Handle>& handle : AllHandles()) handle->ReportSourceChange();
}

void Handle::ReportSourceChange() {
  if (!wants_source_changes || IsGone()) return;
  v4l2_event event{};
  event.type = V4L2_EVENT_SOURCE_CHANGE;
  event.u.src_change.changes = V4L2_EVENT_SRC_CH_RESOLUTION;
  event.sequence = event_sequence_++;
  const std::int64_t now = MonotonicNs();
  event.timestamp.tv_sec = now / kSecondNs;
  event.timestamp.tv_nsec = now % kSecondNs;
  if (events_.size() == kMaxEvents) events_.pop_front();  // As the kernel: the oldest is lost.
  events_.push_back(event);
  const std::uint64_t one = 1;
  if (events_.size() == 1 && write(event_fd_, &one, sizeof one) < 0) return;
}

int Handle::NextEvent(v4l2_event& event) {
  if (events_.empty()) return ENOENT;
  event = events_.front();
  events_.pop_front();
  event.pending = static_cast<std::uint32_t>(events_.size());
  std::uint64_t count = 0;
  if (events_.empty() && read(event_fd_, &count, sizeof count) < 0) return 0;
  return 0;
}

Readiness Handle::Ready() const {
  if (IsGone()) return Readiness::kGone;
  if (!is_streaming_ || has_failed_) return Readiness::kError;
  return !done_.empty() || has_ended_ ? Readiness::kBuffer : Readiness::kNothing;
}

// Makes the timer readable now, at the next moment that the program can see, or never.
void Handle::Arm() {
  std::int64_t at_ns = 0;
  if (Ready() != Readiness::kNothing) {
    at_ns = 1;
  } else if (next_.kind == Next::Kind::kUnplug || next_.kind == Next::Kind::kSourceChange ||
             (next_.kind == Next::Kind::kPicture && !queued_.empty())) {
    at_ns = TickNs(tick_);
  } else if (next_.kind == Next::Kind::kPicture) {
    // Without a buffer only the end of the stream is visible, and no further picture is taken.
    for (int i = state_.next_fault; i < state_.fault_count && at_ns == 0; ++i) {
      const Fault& fault = state_.faults[static_cast<std::size_t>(i)];
      const std::int64_t ahead = std::max<std::int64_t>(fault.at - state_.FaultClock(), 0);
      if (ahead > 0 && state_.faults_count_pictures) break;
      if (EndsStream(fault)) at_ns = TickNs(tick_) + ahead;
    }
    if (at_ns != 0 && at_ns <= MonotonicNs()) at_ns = MonotonicNs() + kSecondNs / 100;
  }
  itimerspec when{};
  when.it_value.tv_sec = at_ns / kSecondNs;
  when.it_value.tv_nsec = at_ns % kSecondNs;
  timerfd_settime(timer_fd_, TFD_TIMER_ABSTIME, &when, nullptr);
}

int Handle::Dequeue(v4l2_buffer& buffer, Capture& capture) {
  if (buffer.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || buffer.memory != V4L2_MEMORY_MMAP) {
    return EINVAL;
  }
  if (!is_streaming_) return EINVAL;
  if (has_failed_) return EIO;
  if (done_.empty()) return has_ended_ ? EPIPE : EAGAIN;
  capture = done_.front();
  done_.pop_front();
  ++state_.taken;
  buffers_[capture.buffer] = {};
  buffer.index = capture.buffer;
  Describe(buffer);
  buffer.flags |=
      (capture.is_last ? V4L2_BUF_FLAG_LAST : 0u) | (capture.has_error ? V4L2_BUF_FLAG_ERROR : 0u);
  buffer.sequence = capture.sequence;
  buffer.timestamp.tv_sec = capture.time_ns / kSecondNs;
  buffer.timestamp.tv_usec = capture.time_ns % kSecondNs / 1000;
  Arm();
  return 0;
}

std::uint32_t Handle::Render(const Capture& capture, std::uint32_t& flags) {
  const std::lock_guard lock(rendering_);
  if (stride_ * capture.buffer + BufferBytes(format_) > memory_.size()) return 0;
  const std::span<std::uint8_t> out =
      memory_.subspan(stride_ * capture.buffer, BufferBytes(format_));
  std::size_t bytes = renderer_.Render(capture.shot, format_, out);
  if (bytes == 0) flags |= V4L2_BUF_FLAG_ERROR;
  if (capture.is_short) bytes /= 2;
  if (capture.is_damaged) Damage(out.first(bytes));
  return static_cast<std::uint32_t>(bytes);
}

}  // namespace pleinair::stand_in

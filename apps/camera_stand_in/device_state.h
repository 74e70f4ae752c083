// What the stand-in's program and its preloaded shim share: one block of memory that every process
// of the command maps, and a file with the pictures. Plain data, no library.
#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <cstdint>

namespace pleinair::stand_in {

// The environment variable with the path of the shared block.
inline constexpr const char* kStateVariable = "PLEINAIR_CAMERA_STAND_IN";
inline constexpr std::uint64_t kStateMagic = 0x33306e6969616c70;  // Changes with the layout.

inline constexpr std::int64_t kSecondNs = 1'000'000'000;

struct Size {
  int width = 0;
  int height = 0;
  bool operator==(const Size&) const = default;
};

// Seconds a frame.
struct Interval {
  std::uint32_t numerator = 1;
  std::uint32_t denominator = 30;
  bool operator==(const Interval&) const = default;
};

// Pictures of one size in the file, one after the other. Each kind is height x width x 3,
// row-major, RGB: 8-bit display codes, and half floats of linear light where 1 saturates the codes.
struct PictureLevel {
  Size size;
  std::int64_t codes_offset = 0;
  std::int64_t linear_offset = 0;
};

enum class FaultKind : std::uint8_t {
  kUnplug,
  kUnplugRenumber,
  kStall,
  kStallForever,
  kFormatChange,
  kTruncate,
  kCorrupt,
  kTimeRepeat,
  kTimeBack,
  kClockBack,
  kClockForward,
  kDrop,
  kControlRefused,
  kControlClamped,
};

// By the clock of faults: see DeviceState::FaultClock.
struct Fault {
  FaultKind kind = FaultKind::kUnplug;
  std::int64_t at = 0;
  bool struck = false;
};

struct Format {
  std::uint32_t pixel_format = 0;
  Size size;
};

// Factors on linear light, of red, green and blue.
using Gains = std::array<float, 3>;

inline constexpr int kMaxFaults = 4096;
inline constexpr int kMaxSizes = 16;
inline constexpr int kMaxIntervals = 16;
inline constexpr int kControlCount = 8;
inline constexpr int kMaxControlDelay = 32;

struct PendingGains {
  std::int64_t from_frame = 0;
  Gains gains{1.0f, 1.0f, 1.0f};
};

// Everything after `mutex` is read and written under it, but for the atomic.
struct DeviceState {
  std::uint64_t magic = kStateMagic;
  pthread_mutex_t mutex{};  // Shared between processes, and robust.

  // The set-up, which does not change.
  char pictures_path[64] = {};
  int number_given = 90;
  int picture_count = 0;
  std::int64_t pictures_to_play = 0;  // Loops included; 0: without end.
  std::int64_t first_utc_ns = 0;
  bool has_linear = false;    // The file has linear light.
  bool codes_follow = false;  // The codes are those of the linear light, by the sRGB curve.
  int level_count = 0;
  std::array<PictureLevel, 2> levels{};
  int size_count = 0;
  std::array<Size, kMaxSizes> sizes{};
  int interval_count = 0;
  std::array<Interval, kMaxIntervals> intervals{};
  Format default_format;
  Interval default_interval;
  std::uint32_t ycbcr_encoding = 0;  // V4L2's numbers.
  std::uint32_t quantization = 0;
  int control_delay = 2;
  bool faults_count_pictures = false;
  bool is_multi_planar = false;  // Multi-planar calls; one plane of memory.

  // The device.
  int number = 90;
  std::uint32_t plug_count = 0;  // A handle of an earlier plugging is dead.
  std::int64_t absent_until_ns = 0;
  std::int64_t stalled_until_ns = 0;
  Format format;
  Interval interval;
  std::uint32_t priority = 0;
  bool size_changed = false;  // By a format-change.
  Size size_before_change;
  std::array<std::int32_t, kControlCount> controls{};
  Gains gains{1.0f, 1.0f, 1.0f};
  int pending_count = 0;
  std::array<PendingGains, kMaxControlDelay + 2> pending{};

  // The stream.
  bool is_streaming = false;
  std::int64_t stream_ns = 0;  // Stream time of the next tick.
  std::int64_t frame = 0;      // Ticks so far, dropped ones included.
  std::int64_t picture = 0;    // The next one to play, loops counted on.
  std::int64_t taken = 0;      // Buffers that programs have dequeued.
  int next_fault = 0;
  int fault_count = 0;
  std::array<Fault, kMaxFaults> faults{};  // In the order in which they strike.
  std::int64_t corrupt_count = 0;

  bool clock_is_set = false;
  std::atomic<std::int64_t> realtime_minus_monotonic_ns{0};

  // Where in the list of faults the stream is: its time, which runs only while the device streams,
  // from 0 at its first picture; or how many pictures were taken.
  std::int64_t FaultClock() const { return faults_count_pictures ? taken : stream_ns; }
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

}  // namespace pleinair::stand_in

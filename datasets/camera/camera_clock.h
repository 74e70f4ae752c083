// UTC of a camera's monotonic timestamps.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "scene/utc_time.h"

namespace pleinair {

// Ties CLOCK_MONOTONIC to CLOCK_REALTIME, and watches the tie: the system's clock may be stepped or
// slewed while a camera streams. Between steps a later timestamp has a later UTC.
class CameraClock {
 public:
  // Both clocks, read as one.
  struct Reading {
    std::chrono::nanoseconds monotonic{0};
    UtcTime utc{};
  };
  using Read = std::function<Reading()>;

  // `read` is called at once and with each UtcOf; none: the system's clocks.
  explicit CameraClock(Read read = {});

  // UTC of a timestamp. Where the system's clock was stepped by more than kLeastStep since the last
  // call, it is UTC of the new clock and `step` says by how much.
  struct Time {
    UtcTime utc{};
    std::optional<std::chrono::nanoseconds> step;
  };
  Time UtcOf(std::chrono::nanoseconds monotonic);
  UtcTime Now() const { return read_().utc; }
  std::chrono::nanoseconds MonotonicNow() const { return read_().monotonic; }

  static constexpr std::chrono::milliseconds kLeastStep{100};

 private:
  Read read_;
  std::chrono::nanoseconds utc_less_monotonic_{0};
  std::chrono::nanoseconds last_{0};  // Timestamp.
};

// A line where the kernel says that the system's clock is not synchronised; empty otherwise.
std::string ClockWarning();

}  // namespace pleinair

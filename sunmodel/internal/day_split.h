// A UTC time as its day and what has passed of it.
#pragma once

#include <chrono>

#include "scene/utc_time.h"

namespace pleinair {

struct DaySplit {
  std::chrono::sys_days day;
  std::chrono::nanoseconds passed{0};  // [0, 24 h).
};

// Right for every UtcTime. The plain `time - floor<days>(time)` overflows in the first day that
// UtcTime holds: that day's midnight is before it.
inline DaySplit SplitAtMidnight(UtcTime time) {
  constexpr std::chrono::nanoseconds kDay = std::chrono::days{1};
  const std::chrono::nanoseconds remainder = time.time_since_epoch() % kDay;
  return {std::chrono::floor<std::chrono::days>(time),
          remainder.count() < 0 ? remainder + kDay : remainder};
}

}  // namespace pleinair

// The time between two frames.
#pragma once

#include <chrono>

#include "scene/utc_time.h"

namespace pleinair::estimation_internal {

inline double SecondsBetween(UtcTime from, UtcTime to) {
  // In double before the difference: three centuries of nanoseconds overflow their 64 bits.
  using Seconds = std::chrono::duration<double>;
  return (Seconds(to.time_since_epoch()) - Seconds(from.time_since_epoch())).count();
}

}  // namespace pleinair::estimation_internal

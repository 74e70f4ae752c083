// The system's clocks.
#pragma once

#include <time.h>

#include <chrono>

namespace pleinair {

// Since the clock's own beginning; `clock` as clock_gettime takes it.
inline std::chrono::nanoseconds ReadClock(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

}  // namespace pleinair

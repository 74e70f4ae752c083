// Wall time in laps.
#pragma once

#include <chrono>

namespace pleinair {

// While one exists, time stands still for the stopwatches of its thread, so that plans by measured
// times do not depend on how busy the machine is. For tests.
class StoppedTime {
 public:
  StoppedTime() { ++count_; }
  ~StoppedTime() { --count_; }
  StoppedTime(const StoppedTime&) = delete;
  StoppedTime& operator=(const StoppedTime&) = delete;

  static bool IsThere() { return count_ > 0; }

 private:
  static inline thread_local int count_ = 0;
};

// Milliseconds since construction or the last lap.
class Stopwatch {
 public:
  double LapMs() {
    const auto now = Now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static Clock::time_point Now() {
    return StoppedTime::IsThere() ? Clock::time_point() : Clock::now();
  }

  Clock::time_point last_ = Now();
};

}  // namespace pleinair

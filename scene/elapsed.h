// Wall time.
#pragma once

#include <chrono>

namespace pleinair {

// Milliseconds since `start`.
inline double MsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return MsSince(start) / 1e3;
}

}  // namespace pleinair

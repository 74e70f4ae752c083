// Processor time, which other programs on the machine hardly change.
#pragma once

#include <time.h>

namespace pleinair {

// Of this process, all threads together.
inline double ProcessorMs() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

}  // namespace pleinair

// The project's time type.
#pragma once

#include <chrono>

namespace pleinair {

// UTC in ticks without leap seconds (as POSIX), 1677 to 2262. For text see sunmodel/time_text.h.
using UtcTime = std::chrono::sys_time<std::chrono::nanoseconds>;

}  // namespace pleinair

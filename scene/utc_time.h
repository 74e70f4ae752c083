// Time as all of the project counts it.
#pragma once

#include <chrono>

namespace pleinair {

// UTC in ticks without leap seconds (as POSIX), 1677 to 2262. Text is sunmodel/time_text.h's.
using UtcTime = std::chrono::sys_time<std::chrono::nanoseconds>;

}  // namespace pleinair

// Available memory, for checks before large work.
#pragma once

#include <cstddef>

namespace pleinair {

// Bytes available without swapping: the system's, or its control group's where that is less. 0
// where the system does not state them.
std::size_t AvailableMemoryBytes();

// Throws std::runtime_error when `bytes` are more than that: one line that begins with `what` and
// ends with `remedy`.
void RequireMemory(std::size_t bytes, const char* what, const char* remedy);

}  // namespace pleinair

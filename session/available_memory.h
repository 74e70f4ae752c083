// How much memory large work may take.
#pragma once

#include <cstddef>

namespace pleinair {

// Bytes that can be had without swapping: the system's, or its control group's where that is less.
// 0 where the system does not say.
std::size_t AvailableMemoryBytes();

// Throws std::runtime_error when `bytes` are more than that: one line that begins with `what` and
// ends with `remedy`.
void RequireMemory(std::size_t bytes, const char* what, const char* remedy);

}  // namespace pleinair

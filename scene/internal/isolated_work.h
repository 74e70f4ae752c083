// Work that may crash, hang or fill the memory, in a process of its own.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

namespace pleinair {

struct IsolationLimits {
  std::uint64_t memory_bytes = 0;  // Beyond what the process has when it starts; at least 1 MiB.
  std::chrono::seconds time{0};    // Of its processor; twice that by the clock. At least 1 s.
};

// The work's process ended without a result, or exceeded a limit; what() says which.
class IsolationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// What `work` returns, from a child of this process: nothing that the work does, to memory or to
// its own end, reaches this process, but for these bytes and what it writes to files. The child has
// this thread alone: the work must not wait for another one. Its error stream is discarded.
//
// Cost    1 ms and more, by the memory of this process, whose tables of pages are copied.
// Throws  std::runtime_error with the message of a std::exception that the work threw;
//         IsolationError. The child is gone by then.
// Threads safe from any.
std::string RunIsolated(const std::function<std::string()>& work, const IsolationLimits& limits);

}  // namespace pleinair

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
  std::chrono::seconds time{0};    // Processor time; wall time may be twice that. At least 1 s.
};

// The work's process ended without a result, or exceeded a limit; what() says which.
class IsolationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Returns the result of `work`, run in a child of this process. Only these bytes and written files
// reach this process; changes of memory or a crash do not. The child has only this thread: the work
// must not wait for another one. Its error stream is discarded.
//
// Cost    1 ms and more, by the memory of this process, whose tables of pages are copied.
// Throws  std::runtime_error with the message of a std::exception that the work threw;
//         IsolationError. The child is gone by then.
// Threads safe from any.
std::string RunIsolated(const std::function<std::string()>& work, const IsolationLimits& limits);

}  // namespace pleinair

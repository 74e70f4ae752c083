// SIGINT, SIGTERM and SIGHUP (a terminal that is closed) as a request to end.
#pragma once

#include <chrono>
#include <csignal>
#include <optional>

namespace pleinair {

// While it lives, these signals wait for Wait in place of ending the process; SIGHUP only where it
// is not ignored, as `nohup` has it. To be constructed before the threads to which it applies.
class StopSignals {
 public:
  StopSignals();
  // Restores the signals' former handling.
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // Whether one has come within this time. A second one, a second or more later, ends the process
  // at once, for as long as some thread waits.
  bool Wait(std::chrono::milliseconds timeout);

 private:
  std::optional<std::chrono::steady_clock::time_point> first_;
  sigset_t before_{};
  sigset_t awaited_{};
};

}  // namespace pleinair

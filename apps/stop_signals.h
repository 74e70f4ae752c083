// SIGINT, SIGTERM and SIGHUP (a terminal that is closed) as a request to end. A second one, a
// second or more later, ends the process at once. Signals that are ignored stay so.
#pragma once

#include <chrono>
#include <csignal>
#include <optional>
#include <utility>
#include <vector>

namespace pleinair {

// While it lives, these signals wait for Wait in place of ending the process. To be constructed
// before the threads to which it applies.
class StopSignals {
 public:
  StopSignals();
  // Restores the signals' former handling.
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // Whether one has come within this time. A second one ends the process for as long as some thread
  // waits.
  bool Wait(std::chrono::milliseconds timeout);

 private:
  std::optional<std::chrono::steady_clock::time_point> first_;
  sigset_t before_{};
  sigset_t awaited_{};
};

// While it lives, these signals set a flag in place of ending the process, whatever threads there
// are. One at a time.
class StopFlag {
 public:
  StopFlag();
  // Restores the signals' former handling.
  ~StopFlag();
  StopFlag(const StopFlag&) = delete;
  StopFlag& operator=(const StopFlag&) = delete;

  bool IsSet() const;

 private:
  std::vector<std::pair<int, struct sigaction>> before_;
};

}  // namespace pleinair

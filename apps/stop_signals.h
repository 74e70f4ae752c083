// SIGINT and SIGTERM as a request to end.
#pragma once

#include <chrono>
#include <csignal>

namespace pleinair {

// While it lives, SIGINT and SIGTERM wait for Wait in place of ending the process. To be made
// before the threads that it is to hold for.
class StopSignals {
 public:
  StopSignals();
  // What it was before.
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  // Whether one has come within this time. From then on a second one ends the process.
  bool Wait(std::chrono::milliseconds timeout);

 private:
  sigset_t before_{};
  sigset_t awaited_{};
};

}  // namespace pleinair

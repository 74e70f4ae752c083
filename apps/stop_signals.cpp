#include "apps/stop_signals.h"

#include <unistd.h>

#include <ctime>

namespace pleinair {

StopSignals::StopSignals() {
  sigemptyset(&awaited_);
  sigaddset(&awaited_, SIGINT);
  sigaddset(&awaited_, SIGTERM);
  // Blocked, an ignored signal would be waited for, too.
  struct sigaction of_hangup {};
  if (sigaction(SIGHUP, nullptr, &of_hangup) == 0 && of_hangup.sa_handler != SIG_IGN) {
    sigaddset(&awaited_, SIGHUP);
  }
  pthread_sigmask(SIG_BLOCK, &awaited_, &before_);
}

StopSignals::~StopSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

bool StopSignals::Wait(std::chrono::milliseconds timeout) {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(timeout);
  const timespec time{static_cast<time_t>(seconds.count()),
                      static_cast<long>(std::chrono::nanoseconds(timeout - seconds).count())};
  const int signal = sigtimedwait(&awaited_, nullptr, &time);
  if (signal < 0) return false;
  constexpr int kEndedBySignal = 128;  // As a shell reports it.
  const auto now = std::chrono::steady_clock::now();
  if (!first_) {
    first_ = now;
    return true;
  }
  // A shell's or `timeout`'s signal comes twice: to the process and to its group.
  constexpr std::chrono::seconds kSameRequest{1};
  if (now - *first_ > kSameRequest) _exit(kEndedBySignal + signal);
  return false;
}

}  // namespace pleinair

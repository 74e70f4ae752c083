#include "apps/stop_signals.h"

#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <ctime>

namespace pleinair {
namespace {

// An ignored signal stays ignored, as `nohup` and a shell's `&` have it: sigtimedwait and a handler
// would receive it.
bool IsIgnored(int signal) {
  struct sigaction now {};
  return sigaction(signal, nullptr, &now) != 0 || now.sa_handler == SIG_IGN;
}
constexpr int kStopSignals[] = {SIGINT, SIGTERM, SIGHUP};

// A shell's or `timeout`'s signal comes twice: to the process and to its group.
constexpr std::chrono::seconds kSameRequest{1};

// Only what a signal handler may call.
[[noreturn]] void EndProcess(int signal) {
  constexpr int kEndedBySignal = 128;  // As a shell reports it.
  _exit(kEndedBySignal + signal);
}

// For the handler: 0 until a signal comes, then the time of the first.
std::atomic<std::int64_t> first_signal_ns = 0;
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

void NoteSignal(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::chrono::nanoseconds time =
      std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
  std::int64_t first_ns = 0;
  if (first_signal_ns.compare_exchange_strong(first_ns, time.count())) return;
  if (time - std::chrono::nanoseconds(first_ns) > kSameRequest) EndProcess(signal);
}

}  // namespace

StopSignals::StopSignals() {
  sigemptyset(&awaited_);
  for (const int signal : kStopSignals) {
    if (!IsIgnored(signal)) sigaddset(&awaited_, signal);
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
  const auto now = std::chrono::steady_clock::now();
  if (!first_) {
    first_ = now;
    return true;
  }
  if (now - *first_ > kSameRequest) EndProcess(signal);
  return false;
}

StopFlag::StopFlag() {
  first_signal_ns = 0;
  struct sigaction noted {};
  noted.sa_handler = NoteSignal;
  noted.sa_flags = SA_RESTART;
  sigemptyset(&noted.sa_mask);
  for (const int signal : kStopSignals) {
    if (IsIgnored(signal)) continue;
    struct sigaction before {};
    if (sigaction(signal, &noted, &before) == 0) before_.emplace_back(signal, before);
  }
}

StopFlag::~StopFlag() {
  for (const auto& [signal, before] : before_) sigaction(signal, &before, nullptr);
}

bool StopFlag::IsSet() const { return first_signal_ns != 0; }

}  // namespace pleinair

#include "apps/progress.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

#include <spdlog/spdlog.h>

namespace pleinair {

Progress ProgressOnStandardError() {
  using Clock = std::chrono::steady_clock;
  const bool terminal = isatty(STDERR_FILENO) == 1;
  // A log gets a line now and then.
  static constexpr std::chrono::seconds kBetweenLines{30};
  return
      [terminal, stage = std::string(), started = Clock::now(), said = Clock::now(), percent = -1](
          std::string_view now, double share) mutable {
        if (stage != now) {
          stage = std::string(now);
          started = said = Clock::now();
          percent = -1;
        }
        if (share >= 1.0) {
          if (terminal && percent >= 0) std::fputs("\r\033[K", stderr);
          spdlog::info("{}: done in {:.1f} s",
                       stage,
                       std::chrono::duration<double>(Clock::now() - started).count());
          stage.clear();
          return;
        }
        const int now_percent = static_cast<int>(100.0 * share);
        if (terminal && now_percent != percent) {
          std::fprintf(stderr, "\r\033[K%s: %d %%", stage.c_str(), now_percent);
          std::fflush(stderr);
        }
        if (!terminal && Clock::now() - said >= kBetweenLines) {
          spdlog::info("{}: {} %", stage, now_percent);
          said = Clock::now();
        }
        percent = now_percent;
      };
}

}  // namespace pleinair

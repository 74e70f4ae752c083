#include "datasets/camera/camera_clock.h"

#include <sys/timex.h>

#include <algorithm>
#include <utility>

#include "datasets/camera/internal/read_clock.h"

namespace pleinair {
namespace {

// NTP slews the system's clock by 500 ppm at most.
constexpr int kSlewDivisor = 2000;

// The reading of one clock lies between two of the other. A thread that is put to sleep between
// them would tie them wrongly, so the closest of three is taken.
CameraClock::Reading ReadSystemClocks() {
  CameraClock::Reading best;
  std::chrono::nanoseconds narrowest = std::chrono::nanoseconds::max();
  for (int attempt = 0; attempt < 3; ++attempt) {
    const std::chrono::nanoseconds before = ReadClock(CLOCK_MONOTONIC);
    const std::chrono::nanoseconds utc = ReadClock(CLOCK_REALTIME);
    const std::chrono::nanoseconds after = ReadClock(CLOCK_MONOTONIC);
    if (after - before >= narrowest) continue;
    narrowest = after - before;
    best = {before + (after - before) / 2, UtcTime(utc)};
  }
  return best;
}

}  // namespace

CameraClock::CameraClock(Read read) : read_(read ? std::move(read) : ReadSystemClocks) {
  const Reading now = read_();
  utc_less_monotonic_ = now.utc.time_since_epoch() - now.monotonic;
  last_ = now.monotonic;
}

CameraClock::Time CameraClock::UtcOf(std::chrono::nanoseconds monotonic) {
  const Reading now = read_();
  const std::chrono::nanoseconds offset = now.utc.time_since_epoch() - now.monotonic;
  const std::chrono::nanoseconds change = offset - utc_less_monotonic_;
  Time time;
  if (std::chrono::abs(change) > kLeastStep) {
    utc_less_monotonic_ = offset;
    time.step = change;
  } else {
    // Over hours a slewed clock moves further than a step. The tie follows it no faster than
    // slewing is: then UTC ascends with the timestamps whatever the readings' errors.
    const std::chrono::nanoseconds most =
        std::max(monotonic - last_, std::chrono::nanoseconds{0}) / kSlewDivisor;
    utc_less_monotonic_ += std::clamp(change, -most, most);
  }
  last_ = monotonic;
  time.utc = UtcTime(monotonic + utc_less_monotonic_);
  return time;
}

std::string ClockWarning() {
  timex state{};
  const int status = adjtimex(&state);
  if (status != TIME_ERROR && (state.status & STA_UNSYNC) == 0) return {};
  return "the system's clock is not synchronised: a minute's error moves the sun by 0.25 deg";
}

}  // namespace pleinair

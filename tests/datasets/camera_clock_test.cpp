// UTC of monotonic timestamps, by clocks that the test turns.
#include "datasets/camera/camera_clock.h"

#include <chrono>

#include <gtest/gtest.h>

#include "sunmodel/time_text.h"

namespace pleinair::camera_clock_test {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

// A machine's clocks: time goes on where the test says so.
class Clocks {
 public:
  CameraClock::Read Reader() {
    return [this] { return CameraClock::Reading{monotonic_, utc_}; };
  }
  void GoOn(nanoseconds duration, nanoseconds utc_gains = 0ns) {
    monotonic_ += duration;
    utc_ += duration + utc_gains;
  }
  void Step(nanoseconds by) { utc_ += by; }
  nanoseconds Monotonic() const { return monotonic_; }
  UtcTime Utc() const { return utc_; }

 private:
  nanoseconds monotonic_ = 5000s;
  UtcTime utc_ = ParseUtcTime("2026-06-21T10:00:00Z");
};

TEST(CameraClock, ATimestampsUtcIsAsLongAgo) {
  Clocks clocks;
  CameraClock clock(clocks.Reader());
  for (int i = 0; i < 100; ++i) {
    clocks.GoOn(33'333'333ns);
    const CameraClock::Time time = clock.UtcOf(clocks.Monotonic() - 12ms);
    EXPECT_EQ(time.utc, clocks.Utc() - 12ms);
    EXPECT_FALSE(time.step);
  }
  EXPECT_EQ(clock.Now(), clocks.Utc());
  EXPECT_EQ(clock.MonotonicNow(), clocks.Monotonic());
}

TEST(CameraClock, FollowsEachStepOnceAndSaysByHowMuch) {
  for (const nanoseconds step : {nanoseconds(-1h), nanoseconds(1s), nanoseconds(-150ms)}) {
    Clocks clocks;
    CameraClock clock(clocks.Reader());
    clocks.GoOn(1s);
    EXPECT_FALSE(clock.UtcOf(clocks.Monotonic()).step);
    clocks.Step(step);
    clocks.GoOn(33ms);
    const CameraClock::Time time = clock.UtcOf(clocks.Monotonic());
    ASSERT_TRUE(time.step);
    EXPECT_EQ(*time.step, step);
    EXPECT_EQ(time.utc, clocks.Utc());
    clocks.GoOn(33ms);
    const CameraClock::Time next = clock.UtcOf(clocks.Monotonic());
    EXPECT_FALSE(next.step);
    EXPECT_EQ(next.utc, clocks.Utc());
  }
}

// As kernels without leap smearing do: UTC's second is repeated.
TEST(CameraClock, ALeapSecondIsAStepOfASecondBack) {
  Clocks clocks;
  CameraClock clock(clocks.Reader());
  clocks.GoOn(1s);
  clock.UtcOf(clocks.Monotonic());
  clocks.GoOn(100ms);
  clocks.Step(-1s);
  const CameraClock::Time time = clock.UtcOf(clocks.Monotonic());
  EXPECT_EQ(time.step, nanoseconds(-1s));
  EXPECT_EQ(time.utc, clocks.Utc());
}

// NTP turns the clock by 50 ppm for an hour: 0.18 s in all, never a step, and UTC keeps up with it.
TEST(CameraClock, SlewingIsNoStepAndIsFollowed) {
  for (const int ppm : {50, -50, 500, -500}) {
    Clocks clocks;
    CameraClock clock(clocks.Reader());
    UtcTime last{};
    constexpr nanoseconds kInterval = 40ms;
    const nanoseconds gain(kInterval.count() / 1'000'000 * ppm);
    for (nanoseconds passed{0}; passed < 1h; passed += kInterval) {
      clocks.GoOn(kInterval, gain);
      const CameraClock::Time time = clock.UtcOf(clocks.Monotonic());
      ASSERT_FALSE(time.step) << ppm << " ppm after " << passed / 1s << " s";
      ASSERT_GT(time.utc, last);
      last = time.utc;
    }
    EXPECT_LT(std::chrono::abs(last - clocks.Utc()), 1ms) << ppm;
  }
}

// What is read of the clocks varies by what comes between two readings; frames may be close.
TEST(CameraClock, ALaterTimestampHasALaterUtcWhateverTheReadingsErrors) {
  Clocks clocks;
  CameraClock clock(clocks.Reader());
  UtcTime last{};
  for (int i = 0; i < 10'000; ++i) {
    clocks.GoOn(i % 7 == 0 ? 1ns : 20'000ns);
    const nanoseconds error((i * 7919) % 60'000'000 - 30'000'000);
    clocks.Step(error);
    const CameraClock::Time time = clock.UtcOf(clocks.Monotonic());
    clocks.Step(-error);
    ASSERT_FALSE(time.step);
    ASSERT_GT(time.utc, last) << i;
    last = time.utc;
  }
}

TEST(CameraClock, ReadsTheSystemsClocks) {
  const CameraClock clock;
  const auto before = std::chrono::system_clock::now();
  const UtcTime now = clock.Now();
  EXPECT_GE(now + 1s, before);
  EXPECT_LE(now - 1s, std::chrono::system_clock::now());
  const nanoseconds monotonic = clock.MonotonicNow();
  EXPECT_GE(std::chrono::steady_clock::now().time_since_epoch() + 1s, monotonic);
}

}  // namespace
}  // namespace pleinair::camera_clock_test

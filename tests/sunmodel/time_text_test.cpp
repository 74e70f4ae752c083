#include "sunmodel/time_text.h"

#include <gtest/gtest.h>

namespace pleinair::time_text_test {
namespace {

using namespace std::chrono_literals;
using std::chrono::sys_days;

TEST(TimeText, ReadsTheFormsOfIso8601) {
  const UtcTime time = sys_days(2005y / 6 / 21) + 9h + 50min;
  EXPECT_EQ(ParseUtcTime("2005-06-21T09:50:00Z"), time);
  EXPECT_EQ(ParseUtcTime("2005-06-21T09:50Z"), time);
  EXPECT_EQ(ParseUtcTime("2005-06-21T09:50:00.25Z"), time + 250ms);
  EXPECT_EQ(ParseUtcTime("2005-06-21T09:50:00.000000001Z"), time + 1ns);
  EXPECT_EQ(ParseUtcTime("2005-06-21T15:35:00+05:45"), time);
  EXPECT_EQ(ParseUtcTime("2005-06-21T15:35:00+0545"), time);
  EXPECT_EQ(ParseUtcTime("2005-06-21T02:50:00-07"), time);
  EXPECT_EQ(ParseUtcTime("2005-06-21T09:50:00-00:00"), time);
}

TEST(TimeText, CrossesMidnightAndTheYearWithItsOffset) {
  EXPECT_EQ(ParseUtcTime("2000-01-01T00:15:00+00:30"), sys_days(1999y / 12 / 31) + 23h + 45min);
  EXPECT_EQ(ParseUtcTime("2003-12-31T20:00:00-09:30"), sys_days(2004y / 1 / 1) + 5h + 30min);
}

TEST(TimeText, WritesAsManyDecimalsAsThereAre) {
  const UtcTime time = sys_days(1969y / 7 / 20) + 20h + 17min + 40s;
  EXPECT_EQ(FormatUtcTime(time), "1969-07-20T20:17:40Z");
  EXPECT_EQ(FormatUtcTime(time + 500ms), "1969-07-20T20:17:40.5Z");
  EXPECT_EQ(FormatUtcTime(time + 1ns), "1969-07-20T20:17:40.000000001Z");
  EXPECT_EQ(FormatUtcTime(time - 40s), "1969-07-20T20:17:00Z");
}

TEST(TimeText, RoundTripsEveryTick) {
  std::int64_t ticks = -9'000'000'000'000'000'000;
  // A step prime to every unit, so that all their digits turn.
  for (; ticks < 9'000'000'000'000'000'000; ticks += 8'999'999'999'999'989) {
    const UtcTime time{std::chrono::nanoseconds(ticks)};
    EXPECT_EQ(ParseUtcTime(FormatUtcTime(time)), time) << ticks;
  }
}

}  // namespace
}  // namespace pleinair::time_text_test

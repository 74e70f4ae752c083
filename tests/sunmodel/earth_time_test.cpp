#include "sunmodel/internal/earth_time.h"

#include <gtest/gtest.h>

#include "sunmodel/internal/leap_seconds.h"
#include "sunmodel/time_text.h"

namespace pleinair::earth_time_test {
namespace {

using std::chrono::sys_days;
using namespace std::chrono_literals;

double DeltaTS(const EarthTime& clocks) {
  return ((clocks.terrestrial.days - clocks.universal.days) +
          (clocks.terrestrial.fraction - clocks.universal.fraction)) *
         86400.0;
}

// Espenak and Meeus, NASA/TP-2006-214141, tables 2-1 and 2-2 (observed values). 1 s is the
// polynomials' own accuracy there, and half the tables' last digit.
TEST(EarthTime, DeltaTAgreesWithThePublishedTable) {
  const struct {
    double year;
    double delta_t_s;
    double tolerance_s;
  } rows[] = {{1700.0, 9.0, 1.0},
              {1800.0, 14.0, 1.0},
              {1900.0, -3.0, 1.0},
              {1950.0, 29.0, 0.6},
              {1955.0, 31.1, 0.3},
              {1960.0, 33.2, 0.3},
              {1965.0, 35.7, 0.3},
              {1970.0, 40.2, 0.3}};
  for (const auto& row : rows) {
    EXPECT_NEAR(PublishedDeltaTS(row.year), row.delta_t_s, row.tolerance_s) << row.year;
  }
}

TEST(EarthTime, PiecesOfDeltaTMeet) {
  for (const double year : {1700.0, 1800.0, 1860.0, 1900.0, 1920.0, 1941.0, 1961.0}) {
    EXPECT_NEAR(PublishedDeltaTS(year - 1e-9), PublishedDeltaTS(year), 0.3) << year;
  }
}

// TT - UTC on the days the earth rotation service's bulletins give: 10 s in 1972, 32 in 1999, 37
// since 2017, and 32.184 s between TT and TAI. UT1 = UTC where nothing is given.
TEST(EarthTime, FollowsTheLeapSeconds) {
  const struct {
    const char* time;
    double tai_minus_utc_s;
  } rows[] = {{"1972-01-01T00:00:00Z", 10.0},
              {"1972-07-01T00:00:00Z", 11.0},
              {"1999-01-01T00:00:00Z", 32.0},
              {"2016-12-31T23:59:59Z", 36.0},
              {"2017-01-01T00:00:00Z", 37.0},
              {"2100-06-01T00:00:00Z", 37.0}};
  for (const auto& row : rows) {
    EXPECT_NEAR(
        DeltaTS(EarthTimeAt(ParseUtcTime(row.time), {})), row.tai_minus_utc_s + 32.184, 1e-5)
        << row.time;
  }
  EXPECT_EQ(TaiMinusUtcS(sys_days(1850y / 1 / 1)), 10.0);
}

// The two ways meet where one takes over from the other.
TEST(EarthTime, GoesOverFromDeltaTToLeapSecondsWithoutAStep) {
  EXPECT_NEAR(DeltaTS(EarthTimeAt(ParseUtcTime("1971-12-31T23:59:59Z"), {})),
              DeltaTS(EarthTimeAt(ParseUtcTime("1972-01-01T00:00:00Z"), {})),
              0.2);
}

TEST(EarthTime, TakesWhatIsGiven) {
  const UtcTime time = ParseUtcTime("2003-10-17T19:30:30Z");
  const EarthTime clocks = EarthTimeAt(time, {-0.4, 67.0});
  EXPECT_EQ(clocks.universal.days, 2452929.5);
  EXPECT_NEAR(clocks.universal.fraction * 86400.0, 19.5 * 3600.0 + 30.0 - 0.4, 1e-9);
  EXPECT_NEAR(DeltaTS(clocks), 67.0, 1e-9);
  // UT1 alone leaves TT to the leap seconds: 32 + 32.184 + 0.4.
  EXPECT_NEAR(DeltaTS(EarthTimeAt(time, {-0.4, {}})), 64.584, 1e-9);
}

}  // namespace
}  // namespace pleinair::earth_time_test

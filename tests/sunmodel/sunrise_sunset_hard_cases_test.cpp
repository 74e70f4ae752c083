#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "sunmodel/angles.h"
#include "sunmodel/sunrise_sunset.h"
#include "sunmodel/time_text.h"

namespace pleinair::sunrise_sunset_hard_cases_test {
namespace {

using namespace std::chrono_literals;

// At the pole the sun rises once a year and sets once, within days of the equinoxes (refraction and
// disc make 0.85 deg, at 0.4 deg a day), and then is up, or down, for half a year.
TEST(SolarDayHardCases, PoleHasOneSunriseAndOneSunsetAYear) {
  for (const double latitude_rad : {std::numbers::pi / 2.0, -std::numbers::pi / 2.0}) {
    int rising = 0;
    int setting = 0;
    for (const UtcTime start :
         {ParseUtcTime("2021-03-15T12:00:00Z"), ParseUtcTime("2021-09-15T12:00:00Z")}) {
      for (int d = 0; d < 15; ++d) {
        const SolarDay day = FindSolarDay({latitude_rad, 0.0, 0.0}, start + d * 24h, {});
        rising += day.sunrise.has_value();
        setting += day.sunset.has_value();
      }
    }
    EXPECT_EQ(rising, 1);
    EXPECT_EQ(setting, 1);
  }
}

// Through a year at the edge of polar night and midnight sun: rising before setting, and whole
// days up or down only where noon says so.
TEST(SolarDayHardCases, IsConsistentThroughTheArcticYear) {
  const Site site{RadFromDeg(69.65), RadFromDeg(18.96), 0.0};
  int up = 0;
  int down = 0;
  for (int d = 0; d < 365; d += 9) {
    const SolarDay day = FindSolarDay(site, ParseUtcTime("2022-01-01T12:00:00Z") + d * 24h, {});
    if (day.sunrise && day.sunset) {
      EXPECT_LT(*day.sunrise, *day.sunset);
      EXPECT_TRUE(day.sun_up_at_noon);
    } else if (!day.sunrise && !day.sunset) {
      ++(day.sun_up_at_noon ? up : down);
    }
  }
  EXPECT_GT(up, 5);    // Some 65 days in Tromso, every ninth of them seen.
  EXPECT_GT(down, 3);  // Some 48.
}

// The sun's passage through the zenith is an ordinary noon.
TEST(SolarDayHardCases, FindsNoonAtTheZenith) {
  const Site site{RadFromDeg(23.4365), 0.0, 0.0};
  const SolarDay day = FindSolarDay(site, ParseUtcTime("2021-06-21T12:00:00Z"), {});
  EXPECT_GT(ComputeSunPosition(site, day.noon).direction_enu.z, std::cos(RadFromDeg(0.01)));
  ASSERT_TRUE(day.sunrise && day.sunset);
}

TEST(SolarDayHardCases, RefusesWhatItCannotAnswer) {
  const UtcTime time = ParseUtcTime("2021-06-21T12:00:00Z");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(FindSolarDay({nan, 0.0, 0.0}, time, {}), std::invalid_argument);
  EXPECT_THROW(FindSolarDay({}, time, {nan, 0.0}), std::invalid_argument);
  EXPECT_THROW(FindSolarDay({}, time, {}, {nan, {}}), std::invalid_argument);
  EXPECT_THROW(FindSolarDay({}, UtcTime::max(), {}), std::invalid_argument);
  EXPECT_THROW(FindSolarDay({}, UtcTime::min(), {}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::sunrise_sunset_hard_cases_test

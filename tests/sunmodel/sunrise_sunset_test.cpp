#include "sunmodel/sunrise_sunset.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sunmodel/angles.h"
#include "sunmodel/time_text.h"

namespace pleinair::sunrise_sunset_test {
namespace {

using namespace std::chrono_literals;

// The air that the usual 34 arc minutes at the horizon stand for.
constexpr Atmosphere kAlmanacAir{1010.0, 10.0};

double SecondsBetween(UtcTime a, UtcTime b) { return std::chrono::duration<double>(a - b).count(); }

struct PublishedDay {
  const char* date;
  double latitude_deg;
  const char* sunrise;
  const char* sunset;
};

// NREL/TP-560-34302 (Reda and Andreas), section A.2's examples at longitude 0, which take 34' of
// refraction and 16' of semidiameter. 6 s = 2 for our 34.4', 1.5 for the disc's true size, 0.7 for
// the parallax that they leave out, 1 for their rounding, each at 0.2 to 0.25 deg a minute.
const PublishedDay kPublished[] = {
    {"1996-07-05T12:00:00Z", -35.0, "1996-07-05T07:08:15Z", "1996-07-05T17:01:04Z"},
    {"2004-12-04T12:00:00Z", -35.0, "2004-12-04T04:38:57Z", "2004-12-04T19:02:02Z"},
    {"1994-01-02T12:00:00Z", 35.0, "1994-01-02T07:08:12Z", "1994-01-02T16:59:55Z"},
};

TEST(SolarDay, RisesAndSetsAtThePublishedTimes) {
  for (const PublishedDay& published : kPublished) {
    const SolarDay day = FindSolarDay({RadFromDeg(published.latitude_deg), 0.0, 0.0},
                                      ParseUtcTime(published.date),
                                      kAlmanacAir,
                                      {0.0, 64.0});
    ASSERT_TRUE(day.sunrise && day.sunset) << published.date;
    EXPECT_NEAR(SecondsBetween(*day.sunrise, ParseUtcTime(published.sunrise)), 0.0, 6.0);
    EXPECT_NEAR(SecondsBetween(*day.sunset, ParseUtcTime(published.sunset)), 0.0, 6.0);
    EXPECT_TRUE(day.sun_up_at_noon);
  }
}

// NREL/TP-560-34302, the worked example of appendix A.5: transit at 11:46:04.97, sunrise at
// 06:12:43, seven hours behind UTC. 0.1 s of transit: 1.5 arc seconds.
TEST(SolarDay, AgreesWithThePublishedTransit) {
  const SolarDay day = FindSolarDay({RadFromDeg(39.742476), RadFromDeg(-105.1786), 1830.14},
                                    ParseUtcTime("2003-10-17T12:30:30-07:00"),
                                    kAlmanacAir,
                                    {0.0, 67.0});
  EXPECT_NEAR(SecondsBetween(day.noon, ParseUtcTime("2003-10-17T11:46:04.97-07:00")), 0.0, 0.1);
  ASSERT_TRUE(day.sunrise);
  EXPECT_NEAR(SecondsBetween(*day.sunrise, ParseUtcTime("2003-10-17T06:12:43-07:00")), 0.0, 6.0);
}

TEST(SolarDay, PutsTheUpperLimbOnTheHorizon) {
  const Site site{RadFromDeg(57.05), RadFromDeg(9.92), 15.0};
  const Atmosphere air = StandardAtmosphere(site.height_m);
  const SolarDay day = FindSolarDay(site, ParseUtcTime("2005-06-21T09:50:00Z"), air);
  ASSERT_TRUE(day.sunrise && day.sunset);
  for (const UtcTime time : {*day.sunrise, *day.sunset}) {
    const SunPosition sun = ComputeSunPosition(site, time);
    const double limb_rad = sun.ElevationRad() + sun.angular_radius_rad;
    // A millisecond of the search is 15 mas.
    EXPECT_NEAR(limb_rad + RefractionRad(limb_rad, air), 0.0, RadFromDeg(1e-5));
  }
  EXPECT_NEAR(ComputeSunPosition(site, day.noon).AzimuthRad(), RadFromDeg(180.0), RadFromDeg(1e-5));
}

TEST(SolarDay, KnowsMidnightSunAndPolarNight) {
  const Site longyearbyen{RadFromDeg(78.22), RadFromDeg(15.65), 0.0};
  const SolarDay june = FindSolarDay(longyearbyen, ParseUtcTime("2020-06-21T12:00:00Z"), {});
  EXPECT_FALSE(june.sunrise || june.sunset);
  EXPECT_TRUE(june.sun_up_at_noon);
  const SolarDay december = FindSolarDay(longyearbyen, ParseUtcTime("2020-12-21T12:00:00Z"), {});
  EXPECT_FALSE(december.sunrise || december.sunset);
  EXPECT_FALSE(december.sun_up_at_noon);
}

TEST(SolarDay, HoldsItsTimeAtEveryLongitude) {
  const UtcTime time = ParseUtcTime("2021-03-01T02:00:00Z");
  for (double longitude_deg = -540.0; longitude_deg <= 540.0; longitude_deg += 45.0) {
    const SolarDay day = FindSolarDay({0.3, RadFromDeg(longitude_deg), 0.0}, time, {});
    // Half a day, the equation of time beside it.
    EXPECT_LE(std::abs(SecondsBetween(day.noon, time)), 12.0 * 3600.0 + 17.0 * 60.0);
    ASSERT_TRUE(day.sunrise && day.sunset);
    EXPECT_LT(*day.sunrise, day.noon);
    EXPECT_LT(day.noon, *day.sunset);
  }
}

}  // namespace
}  // namespace pleinair::sunrise_sunset_test

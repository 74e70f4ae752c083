#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/refraction.h"
#include "sunmodel/sun_position.h"
#include "sunmodel/time_text.h"
#include "tests/sunmodel/directions.h"

namespace pleinair::sun_position_hard_cases_test {
namespace {

using namespace std::chrono_literals;
using std::chrono::sys_days;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <typename Call>
std::string ErrorOf(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

// The earth turns 15.04 deg an hour, and nothing else moves the sun as fast: no direction,
// refracted or not, may move faster, wherever the site is and whatever the azimuth does.
void ExpectNoJump(const Site& site, UtcTime start, UtcTime end, std::chrono::seconds step) {
  const Atmosphere air = StandardAtmosphere(site.height_m);
  const double most = RadFromDeg(double(step.count()) * 15.05 / 3600.0);
  glm::dvec3 before = ComputeSunPosition(site, start).direction_enu;
  glm::dvec3 apparent_before = ApparentDirection(before, air);
  for (UtcTime time = start + step; time < end; time += step) {
    const glm::dvec3 now = ComputeSunPosition(site, time).direction_enu;
    const glm::dvec3 apparent = ApparentDirection(now, air);
    ASSERT_NEAR(glm::length(now), 1.0, 1e-12);
    ASSERT_LE(glm::distance(before, now), most) << FormatUtcTime(time);
    // The fade of refraction below the horizon doubles the pace at most: 0.65 deg x 1.5 a degree.
    ASSERT_LE(glm::distance(apparent_before, apparent), 2.2 * most) << FormatUtcTime(time);
    before = now;
    apparent_before = apparent;
  }
}

TEST(SunPositionHardCases, DirectionNeverJumpsAtTheZenith) {
  // Steps of a second around the noon at which the sun passes the zenith, north or south of it.
  for (const double latitude_deg : {23.4364, 23.4365, 23.4366, 0.0, -10.0}) {
    ExpectNoJump({RadFromDeg(latitude_deg), 0.0, 0.0},
                 sys_days(2021y / 6 / 21) + 11h + 57min,
                 sys_days(2021y / 6 / 21) + 12h + 7min,
                 1s);
  }
  ExpectNoJump(
      {RadFromDeg(23.43), 0.0, 0.0}, sys_days(2026y / 6 / 21), sys_days(2026y / 6 / 22), 20s);
}

TEST(SunPositionHardCases, DirectionNeverJumpsAtThePoles) {
  for (const double latitude_rad : {kPi / 2.0, -kPi / 2.0, RadFromDeg(89.9999)}) {
    ExpectNoJump(
        {latitude_rad, 0.0, 0.0}, sys_days(2021y / 3 / 19), sys_days(2021y / 3 / 21), 120s);
  }
}

// Seen from the pole the sun's elevation is its declination, whatever the hour: at the solstice of
// 2021 the obliquity (mean 23.4365 deg, nutation 9.2" times the cosine of the node's 70 deg), less
// parallax, 8.7" times the elevation's cosine. 0.0010 deg = 0.0009 for half a day (0.49 deg of
// orbit, 23.44 x 0.49^2 / 2 in radians) to either side, 0.0001 for the smaller terms of nutation.
TEST(SunPositionHardCases, PoleSeesTheDeclination) {
  for (int hour = 0; hour < 24; ++hour) {
    const UtcTime time = sys_days(2021y / 6 / 20) + 16h + std::chrono::hours{hour};
    EXPECT_NEAR(DegFromRad(ComputeSunPosition({kPi / 2.0, 0.0, 0.0}, time).ElevationRad()),
                23.4352,
                0.0010);
  }
}

TEST(SunPositionHardCases, OneInstantGivesOneDirectionHoweverWritten) {
  const Site site{RadFromDeg(57.05), RadFromDeg(9.92), 15.0};
  const struct {
    const char* one;
    const char* other;
  } pairs[] = {{"2005-06-21T09:50:00Z", "2005-06-21T15:35:00+05:45"},
               {"2005-06-21T09:50:00.0Z", "2005-06-21T06:20:00.000-03:30"},
               {"2004-02-29T23:30:00Z", "2004-03-01T12:15:00+12:45"},
               {"2017-01-01T00:00:00Z", "2016-12-31T23:59:60Z"},
               {"1900-01-01T00:00:00Z", "1899-12-31T19:00:00-05"},
               {"2100-12-31T23:59:59.5Z", "2101-01-01T05:29:59.5+0530"}};
  for (const auto& pair : pairs) {
    EXPECT_LE(glm::distance(ComputeSunPosition(site, ParseUtcTime(pair.one)).direction_enu,
                            ComputeSunPosition(site, ParseUtcTime(pair.other)).direction_enu),
              1e-12)
        << pair.one;
  }
}

TEST(SunPositionHardCases, LongitudesOfOneMeridianGiveOneDirection) {
  const UtcTime time = ParseUtcTime("2019-09-09T23:00:00Z");
  for (const double longitude_deg : {180.0, -105.0, 0.0, 33.3}) {
    const glm::dvec3 plain =
        ComputeSunPosition({0.4, RadFromDeg(longitude_deg), 0.0}, time).direction_enu;
    for (const double turns : {-3.0, -1.0, 1.0, 2.0}) {
      const double longitude_rad = RadFromDeg(longitude_deg) + turns * 2.0 * kPi;
      EXPECT_LE(
          glm::distance(ComputeSunPosition({0.4, longitude_rad, 0.0}, time).direction_enu, plain),
          1e-12);
    }
  }
}

// Leap seconds and the change from Delta T to their table may move the sun by no more than they are
// worth: 15 arc seconds a second of UT1, of which UTC without leap seconds jumps none.
TEST(SunPositionHardCases, PassesLeapSecondsAndEpochsSmoothly) {
  const Site site{0.8, 0.2, 100.0};
  for (const auto day : {sys_days(2017y / 1 / 1),
                         sys_days(1972y / 1 / 1),
                         sys_days(1961y / 1 / 1),
                         sys_days(1941y / 1 / 1),
                         sys_days(1920y / 1 / 1),
                         sys_days(1900y / 1 / 1),
                         sys_days(2000y / 2 / 29),
                         sys_days(2100y / 3 / 1),
                         sys_days(2101y / 1 / 1)}) {
    ExpectNoJump(site, day - 10s, day + 10s, 1s);
  }
}

TEST(SunPositionHardCases, KnowsItsSpan) {
  EXPECT_FALSE(IsInEphemerisSpan(ParseUtcTime("1899-12-31T23:59:59.999999999Z")));
  EXPECT_TRUE(IsInEphemerisSpan(ParseUtcTime("1900-01-01T00:00:00Z")));
  EXPECT_TRUE(IsInEphemerisSpan(ParseUtcTime("2100-12-31T23:59:59.999999999Z")));
  EXPECT_FALSE(IsInEphemerisSpan(ParseUtcTime("2101-01-01T00:00:00Z")));
}

TEST(SunPositionHardCases, AnswersAtTheEndsOfTime) {
  for (const UtcTime time : {UtcTime::min(), UtcTime::max(), UtcTime{}}) {
    const SunPosition sun = ComputeSunPosition({0.5, 0.5, 0.0}, time);
    EXPECT_NEAR(glm::length(sun.direction_enu), 1.0, 1e-12);
    EXPECT_NEAR(sun.distance_au, 1.0, 0.018);
  }
}

// Height moves the sun by parallax alone: 400 km over the distance is 2.7e-6.
TEST(SunPositionHardCases, HeightMovesTheSunByItsParallax) {
  const UtcTime time = ParseUtcTime("2019-09-09T09:00:00Z");
  const glm::dvec3 ground = ComputeSunPosition({0.4, 0.1, 0.0}, time).direction_enu;
  for (const double height_m : {-430.0, 8848.0, 400e3}) {
    const glm::dvec3 there = ComputeSunPosition({0.4, 0.1, height_m}, time).direction_enu;
    EXPECT_LE(glm::distance(there, ground), 1.1 * std::abs(height_m) / 1.49e11 + 1e-12);
  }
}

// A second method: the series of Michalsky (Solar Energy 40(3), 1988), good to 0.01 deg from 1950
// to 2050, at random places and times. 0.0135 = 0.01, the parallax that it leaves out 0.0025, the
// diurnal aberration and Delta T's 0.001.
TEST(SunPositionHardCases, AgreesWithASecondMethodEverywhere) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const UtcTime start = sys_days(1950y / 1 / 1);
  const double span_s = 100.0 * 365.25 * 86400.0;
  int below = 0;
  int south = 0;
  for (int i = 0; i < 2000; ++i) {
    const Site site{std::asin(2.0 * unit(random) - 1.0), 2.0 * kPi * (unit(random) - 0.5), 0.0};
    const auto ticks = std::chrono::nanoseconds(std::int64_t(unit(random) * span_s * 1e9));
    const UtcTime time = start + ticks;
    const double days =
        std::chrono::duration<double, std::ratio<86400>>(time - sys_days(2000y / 1 / 1)).count() -
        0.5;

    const double mean_longitude = RadFromDeg(std::fmod(280.460 + 0.9856474 * days, 360.0));
    const double anomaly = RadFromDeg(std::fmod(357.528 + 0.9856003 * days, 360.0));
    const double longitude = mean_longitude + RadFromDeg(1.915) * std::sin(anomaly) +
                             RadFromDeg(0.020) * std::sin(2.0 * anomaly);
    const double obliquity = RadFromDeg(23.439 - 0.0000004 * days);
    const glm::dvec3 equatorial{std::cos(longitude),
                                std::cos(obliquity) * std::sin(longitude),
                                std::sin(obliquity) * std::sin(longitude)};
    const double utc_days = std::floor(days + 0.5) - 0.5;
    const double hour = (days - utc_days) * 24.0;
    const double sidereal =
        RadFromDeg(15.0 * std::fmod(6.697375 + 0.0657098242 * days + hour, 24.0)) +
        site.longitude_rad;
    const double toward = equatorial.x * std::cos(sidereal) + equatorial.y * std::sin(sidereal);
    const double east = -equatorial.x * std::sin(sidereal) + equatorial.y * std::cos(sidereal);
    const double s = std::sin(site.latitude_rad);
    const double c = std::cos(site.latitude_rad);
    const glm::dvec3 expected{east, c * equatorial.z - s * toward, s * equatorial.z + c * toward};

    const glm::dvec3 sun = ComputeSunPosition(site, time).direction_enu;
    ASSERT_LE(AngleDeg(sun, expected), 0.0135) << FormatUtcTime(time);
    below += sun.z < 0.0;
    south += site.latitude_rad < 0.0;
  }
  EXPECT_GT(below, 500);
  EXPECT_GT(south, 500);
}

TEST(SunPositionHardCases, RefusesBadInputByName) {
  const UtcTime time = ParseUtcTime("2019-09-09T09:00:00Z");
  EXPECT_THAT(ErrorOf([&] {
                ComputeSunPosition({39.74, -1.8, 0.0}, time);
              }),
              HasSubstr("latitude_rad is 39.74"));
  EXPECT_THAT(ErrorOf([&] {
                ComputeSunPosition({0.0, kNan, 0.0}, time);
              }),
              HasSubstr("longitude_rad is nan"));
  EXPECT_THAT(ErrorOf([&] {
                ComputeSunPosition({}, time, {kNan, {}});
              }),
              HasSubstr("ut1_minus_utc_s is nan"));
  EXPECT_THAT(ErrorOf([&] {
                ComputeSunPosition({}, time, {61.0, {}});
              }),
              HasSubstr("ut1_minus_utc_s is 61"));
  EXPECT_THAT(ErrorOf([&] {
                ComputeSunPosition({}, time, {{}, 1e6});
              }),
              HasSubstr("tt_minus_ut1_s is 1000000"));
}

}  // namespace
}  // namespace pleinair::sun_position_hard_cases_test

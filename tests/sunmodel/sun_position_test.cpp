#include "sunmodel/sun_position.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sunmodel/refraction.h"
#include "sunmodel/time_text.h"
#include "tests/sunmodel/directions.h"

namespace pleinair::sun_position_test {
namespace {

using namespace std::chrono_literals;

// What our own chain leaves out or rounds: polar motion 0.0001, ephemeris 0.000003, nutation less.
constexpr double kChainDeg = 0.0002;
// How far one published refraction formula is from another in the same air (their scatter between
// Bennett, Saemundsson and the Almanac's): the bar of the direction, high up and low down.
constexpr double kRefractionDeg = 0.01;
constexpr double kLowRefractionDeg = 0.02;
constexpr double kLowElevationDeg = 5.0;

Site SiteFromDegrees(double latitude_deg, double longitude_deg, double height_m) {
  return {RadFromDeg(latitude_deg), RadFromDeg(longitude_deg), height_m};
}

const std::filesystem::path kTables =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "data" / "sun_position";

struct PublishedCase {
  const char* source;
  const char* time_utc;
  double latitude_deg;
  double longitude_deg;
  double height_m;
  double delta_t_s;
  double azimuth_deg;
  double zenith_deg;  // Without refraction.
  double table_deg;   // The source's own last digit or stated accuracy.
};

// UT1 = UTC in all of them.
const PublishedCase kPublished[] = {
    {"NREL/TP-560-34302 (Reda and Andreas), table A5.1",
     "2003-10-17T19:30:30Z",
     39.742476,
     -105.1786,
     1830.14,
     67.0,
     194.340241,
     50.127954,
     0.0003},
    {"pvlib, expected_solpos_multi (NREL's algorithm)",
     "2003-10-18T19:30:30Z",
     39.742476,
     -105.1786,
     1830.14,
     67.0,
     194.311132,
     50.494804,
     0.0003},
    {"NOVAS 3.1, JD 2440423.3458",
     "1969-07-20T20:18:00Z",
     38.9215,
     -77.0669,
     92.0,
     0.0,
     258.5550717846,
     43.2759664285,
     0.0001},
    {"NOVAS 3.1, JD 2448031.5",
     "1990-05-20T00:00:00Z",
     38.9215,
     -77.0669,
     92.0,
     0.0,
     293.9563663727,
     87.7790530630,
     0.0001},
    {"NOVAS 3.1, JD 2451545.0",
     "2000-01-01T12:00:00Z",
     38.9215,
     -77.0669,
     92.0,
     0.0,
     115.3200845147,
     95.4865054150,
     0.0001},
    {"NOVAS 3.1, JD 2456164.5",
     "2012-08-25T00:00:00Z",
     38.9215,
     -77.0669,
     92.0,
     0.0,
     286.0963200139,
     92.7384076915,
     0.0001},
    {"US Naval Observatory, 2008",
     "2008-07-22T14:51:25Z",
     5.0,
     -12.0,
     0.0,
     65.6,
     300.599194444,
     32.1989722222,
     0.0003},
    {"US Naval Observatory, 2008",
     "2008-03-15T22:50:12Z",
     24.0,
     -165.0,
     0.0,
     65.6,
     169.434083333,
     26.0873055556,
     0.0003},
    {"US Naval Observatory, 2008",
     "2008-07-13T12:30:46Z",
     85.0,
     61.0,
     0.0,
     65.6,
     249.179416667,
     66.4192777778,
     0.0003},
    {"US Naval Observatory, 2008",
     "2008-05-04T06:07:59Z",
     71.0,
     107.0,
     0.0,
     65.6,
     203.064777778,
     56.2,
     0.0003},
    {"US Naval Observatory, 2008",
     "2008-05-03T00:32:21Z",
     32.0,
     87.0,
     0.0,
     65.6,
     79.48325,
     76.8759444444,
     0.0003},
    {"US Naval Observatory, 2008",
     "2008-06-24T13:54:22Z",
     50.0,
     -73.0,
     0.0,
     65.6,
     110.405111111,
     43.8595,
     0.0003},
};

TEST(SunPosition, AgreesWithPublishedPositions) {
  for (const PublishedCase& c : kPublished) {
    const SunPosition sun =
        ComputeSunPosition(SiteFromDegrees(c.latitude_deg, c.longitude_deg, c.height_m),
                           ParseUtcTime(c.time_utc),
                           {0.0, c.delta_t_s});
    EXPECT_LE(AngleDeg(sun.direction_enu, DirectionFromDegrees(c.azimuth_deg, 90.0 - c.zenith_deg)),
              c.table_deg + kChainDeg)
        << c.source << ", " << c.time_utc;
  }
}

// Earth-sun distance and semidiameter at perihelion and aphelion of 2003 and 2020 (Astronomical
// Almanac: 0.98332 au, 16' 15.9"; 1.01669 au, 15' 43.9"), to the site's own 4.3e-5 au and 0.1".
TEST(SunPosition, DiscGrowsTowardsPerihelion) {
  const SunPosition near = ComputeSunPosition({}, ParseUtcTime("2003-01-04T05:00:00Z"));
  EXPECT_NEAR(near.distance_au, 0.98332, 5e-5);
  EXPECT_NEAR(DegFromRad(near.angular_radius_rad) * 3600.0, 975.9, 0.15);
  const SunPosition far = ComputeSunPosition({}, ParseUtcTime("2020-07-04T12:00:00Z"));
  EXPECT_NEAR(far.distance_au, 1.01669, 5e-5);
  EXPECT_NEAR(DegFromRad(far.angular_radius_rad) * 3600.0, 943.9, 0.15);
}

TEST(SunPosition, AzimuthAndElevationSpellTheDirection) {
  for (double azimuth_deg = 0.0; azimuth_deg < 360.0; azimuth_deg += 15.0) {
    for (double elevation_deg = -75.0; elevation_deg <= 75.0; elevation_deg += 15.0) {
      const SunPosition sun{DirectionFromDegrees(azimuth_deg, elevation_deg)};
      EXPECT_NEAR(DegFromRad(sun.AzimuthRad()), azimuth_deg, 1e-12);
      EXPECT_NEAR(DegFromRad(sun.ElevationRad()), elevation_deg, 1e-12);
    }
  }
}

// With Delta T held, a second of UT1 takes the sun 15.00 arc seconds westwards (its mean day); a
// second of Delta T alone moves it 0.041 eastwards on its orbit (360 deg in 365.2422 days). Both
// differ by season by less than 0.02 of that.
TEST(SunPosition, FollowsTheGivenEarthRotation) {
  const Site equator;
  const UtcTime noon = ParseUtcTime("2010-03-21T12:00:00Z");
  const glm::dvec3 plain = ComputeSunPosition(equator, noon, {0.0, 66.0}).direction_enu;
  const glm::dvec3 turned = ComputeSunPosition(equator, noon, {0.5, 66.0}).direction_enu;
  const glm::dvec3 later = ComputeSunPosition(equator, noon, {0.0, 76.0}).direction_enu;
  EXPECT_NEAR(AngleDeg(plain, turned) * 3600.0, 0.5 * 15.0, 0.01);
  EXPECT_LT(turned.x, plain.x);
  EXPECT_NEAR(AngleDeg(plain, later) * 3600.0, 10.0 * 0.0411, 0.01);
  EXPECT_GT(later.x, plain.x);
}

// TT - UTC is 64.184 s in 2005 by the leap second table, and UT1 stands in for UTC.
TEST(SunPosition, TakesLeapSecondsFromTheTable) {
  const Site site = SiteFromDegrees(50.0, 10.0, 0.0);
  const UtcTime time = ParseUtcTime("2005-06-01T08:00:00Z");
  EXPECT_LT(AngleDeg(ComputeSunPosition(site, time).direction_enu,
                     ComputeSunPosition(site, time, {0.0, 64.184}).direction_enu),
            1e-10);
}

TEST(SunPosition, AgreesWithTheReferenceVectors) {
  std::ifstream file(kTables / "vectors.json");
  if (!file) GTEST_SKIP() << "no reference data at " << kTables;
  const nlohmann::json table = nlohmann::json::parse(file);
  int outside_span = 0;
  int checked = 0;
  for (const nlohmann::json& row : table.at("vectors")) {
    const std::string id = row.at("id");
    SCOPED_TRACE(id);
    const UtcTime time = ParseUtcTime(row.at("time_utc").get<std::string>());
    // What jpl and computed rows give is true UTC; all others take UT1 = UTC.
    EarthRotation rotation;
    if (!id.starts_with("jpl-") && !id.starts_with("computed-")) {
      rotation = {0.0, row.at("delta_t_s").get<double>()};
    }
    const Site site = SiteFromDegrees(row.at("lat_deg"), row.at("lon_east_deg"), row.at("elev_m"));
    glm::dvec3 sun = ComputeSunPosition(site, time, rotation).direction_enu;
    const double elevation_deg = 90.0 - row.at("zenith_deg").get<double>();
    double tolerance_deg = std::max(row.at("tol_deg").get<double>(), 0.0005);
    if (row.at("zenith_is_refracted").get<bool>()) {
      sun = ApparentDirection(sun, {row.at("pressure_hpa"), row.at("temp_c")});
      tolerance_deg += elevation_deg < kLowElevationDeg ? kLowRefractionDeg : kRefractionDeg;
    }
    const double error_deg =
        AngleDeg(sun, DirectionFromDegrees(row.at("azimuth_deg_from_north_cw"), elevation_deg));
    RecordProperty(id, std::to_string(error_deg));
    if (!IsInEphemerisSpan(time)) {
      ++outside_span;
      continue;
    }
    EXPECT_LE(error_deg, tolerance_deg);
    ++checked;
  }
  EXPECT_GE(checked, 15);
  EXPECT_GE(outside_span, 1);
}

TEST(SunPosition, AgreesWithTheNavalObservatoryTable) {
  std::ifstream file(kTables / "usno_2008.csv");
  if (!file) GTEST_SKIP() << "no reference data at " << kTables;
  std::string line;
  std::getline(file, line);
  int rows = 0;
  double worst_deg = 0.0;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::string time;
    std::getline(fields, time, ',');
    double value[5] = {};
    for (double& v : value) {
      std::string field;
      ASSERT_TRUE(std::getline(fields, field, ',')) << line;
      v = std::stod(field);
    }
    const SunPosition sun =
        ComputeSunPosition(SiteFromDegrees(value[0], value[1], value[2]), ParseUtcTime(time));
    worst_deg = std::max(
        worst_deg, AngleDeg(sun.direction_enu, DirectionFromDegrees(value[3], 90.0 - value[4])));
    ++rows;
  }
  RecordProperty("worst_deg", std::to_string(worst_deg));
  EXPECT_EQ(rows, 3130);
  EXPECT_LE(worst_deg, 0.0005);
}

}  // namespace
}  // namespace pleinair::sun_position_test

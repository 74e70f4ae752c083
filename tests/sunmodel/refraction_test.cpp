#include "sunmodel/refraction.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sunmodel/angles.h"
#include "tests/sunmodel/directions.h"

namespace pleinair::refraction_test {
namespace {

double RefractionArcMin(double airless_deg, const Atmosphere& air) {
  return DegFromRad(RefractionRad(RadFromDeg(airless_deg), air)) * 60.0;
}

// What taking the zenith's offset off adds, in arc minutes; beside it the sources' last digit.
constexpr double kZenithOffset = 0.0020;

// Meeus, Astronomical Algorithms, example 16.a: an upper limb at 33.246' is lifted by 24.618'.
TEST(Refraction, AgreesWithMeeusNearTheHorizon) {
  EXPECT_NEAR(RefractionArcMin(33.246 / 60.0, {1010.0, 10.0}), 24.618, kZenithOffset + 0.001);
}

// NREL/TP-560-34302, table A5.1: 0.016332 deg at 39.872046 deg, 820 hPa and 11 C.
TEST(Refraction, AgreesWithTheSolarPositionAlgorithm) {
  EXPECT_NEAR(RefractionArcMin(39.872046, {820.0, 11.0}), 0.016332 * 60.0, kZenithOffset + 3e-5);
}

// NOVAS 3.1 with 1010 hPa and 10 C, by another formula (Bennett): 0.1' is what the two differ by in
// Bennett's own comparison.
TEST(Refraction, AgreesWithAnotherFormula) {
  EXPECT_NEAR(RefractionArcMin(90.0 - 87.77905306, {1010.0, 10.0}),
              (87.77905306 - 87.51062011) * 60.0,
              0.1);
  EXPECT_NEAR(RefractionArcMin(90.0 - 43.27596643, {1010.0, 10.0}),
              (43.27596643 - 43.26037125) * 60.0,
              0.1);
}

// Around 34' at the horizon for the *apparent* position there, in the textbook's air; 0.5' is the
// scatter of textbooks (33.8' to 34.5').
TEST(Refraction, IsThirtyFourMinutesAtTheHorizon) {
  double airless_deg = 0.0;
  for (int i = 0; i < 50; ++i) airless_deg = -RefractionArcMin(airless_deg, {1010.0, 10.0}) / 60.0;
  EXPECT_NEAR(-airless_deg * 60.0, 34.0, 0.5);
}

TEST(Refraction, GrowsWithTheDensityOfTheAir) {
  const double once = RefractionArcMin(20.0, {500.0, 10.0});
  EXPECT_NEAR(RefractionArcMin(20.0, {1000.0, 10.0}), 2.0 * once, 1e-12);
  EXPECT_LT(RefractionArcMin(20.0, {500.0, 30.0}), once);
  EXPECT_EQ(RefractionArcMin(20.0, {0.0, 10.0}), 0.0);
}

TEST(Refraction, LiftsTheDirectionByTheAngleInItsVertical) {
  const Atmosphere air;
  for (double elevation_deg = -1.5; elevation_deg < 90.0; elevation_deg += 3.7) {
    const glm::dvec3 airless = DirectionFromDegrees(130.0, elevation_deg);
    const double lift_deg = DegFromRad(RefractionRad(RadFromDeg(elevation_deg), air));
    const glm::dvec3 expected = DirectionFromDegrees(130.0, elevation_deg + lift_deg);
    EXPECT_LT(AngleDeg(ApparentDirection(airless, air), expected), 1e-12);
    // A direction of another length is the same direction.
    EXPECT_LT(AngleDeg(ApparentDirection(7.0 * airless, air), expected), 1e-12);
  }
}

// U.S. Standard Atmosphere 1976 (the same as ISO 2533 there), table I, by geometric height; each to
// half its last digit and 0.01 %.
TEST(StandardAtmosphere, AgreesWithThePublishedTable) {
  const struct {
    double height_m;
    double pressure_hpa;
    double temperature_k;
  } rows[] = {{0.0, 1013.25, 288.150},
              {1000.0, 898.76, 281.651},
              {5000.0, 540.48, 255.676},
              {10000.0, 264.99, 223.252},
              {15000.0, 121.11, 216.650},
              {20000.0, 55.293, 216.650}};
  for (const auto& row : rows) {
    const Atmosphere air = StandardAtmosphere(row.height_m);
    EXPECT_NEAR(air.pressure_hpa, row.pressure_hpa, 0.005 + 1e-4 * row.pressure_hpa);
    EXPECT_NEAR(air.temperature_c + 273.15, row.temperature_k, 0.001);
  }
}

// Kasten and Young: 38 at the horizon (their integration 38.09, their formula 37.92).
TEST(AirMass, IsThirtyEightAtTheHorizon) { EXPECT_NEAR(RelativeAirMass(0.0), 38.0, 0.1); }

// High up the earth is flat: 1 / sin, with 0.3 % for its curvature at 30 deg.
TEST(AirMass, IsThatOfAFlatEarthHighUp) {
  for (double elevation_deg = 30.0; elevation_deg <= 90.0; elevation_deg += 5.0) {
    const double elevation_rad = RadFromDeg(elevation_deg);
    const double flat = 1.0 / std::sin(elevation_rad);
    EXPECT_NEAR(RelativeAirMass(elevation_rad), flat, 0.003 * flat);
  }
  EXPECT_NEAR(RelativeAirMass(std::numbers::pi / 2.0), 1.0, 0.0005);
}

}  // namespace
}  // namespace pleinair::refraction_test

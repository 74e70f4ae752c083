#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/refraction.h"
#include "tests/sunmodel/directions.h"

namespace pleinair::refraction_hard_cases_test {
namespace {

using ::testing::HasSubstr;

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

// The corners of what an Atmosphere may be, an ordinary one, and none.
const Atmosphere kAirs[] = {
    {1013.25, 15.0}, {1200.0, -150.0}, {1200.0, 100.0}, {0.0, 15.0}, {820.0, 11.0}};

TEST(RefractionHardCases, ApparentElevationRisesWithoutJumps) {
  constexpr double kStepDeg = 1e-3;
  for (const Atmosphere& air : kAirs) {
    double before_deg = -90.0;
    for (int i = 0; i <= 180000; ++i) {
      const double airless_deg = std::min(-90.0 + i * kStepDeg, 90.0);
      const double lift_rad = RefractionRad(RadFromDeg(airless_deg), air);
      ASSERT_GE(lift_rad, 0.0) << airless_deg;
      const double apparent_deg = airless_deg + DegFromRad(lift_rad);
      ASSERT_LE(apparent_deg, 90.0 + 1e-12);
      if (i > 0) {
        ASSERT_GT(apparent_deg, before_deg) << airless_deg;
        // The fade takes the densest cold air's 1.8 deg off within a degree, 1.5 times as fast in
        // the middle: 3.7 times the step with the step itself.
        ASSERT_LT(apparent_deg - before_deg, 4.0 * kStepDeg) << airless_deg;
      }
      before_deg = apparent_deg;
    }
  }
}

TEST(RefractionHardCases, IsNoneFarBelowTheHorizonAndAtTheZenith) {
  for (const Atmosphere& air : kAirs) {
    EXPECT_EQ(RefractionRad(-std::numbers::pi / 2.0, air), 0.0);
    EXPECT_EQ(RefractionRad(RadFromDeg(-2.0), air), 0.0);
    EXPECT_LT(RefractionRad(std::numbers::pi / 2.0, air), 1e-15);
  }
  EXPECT_GT(RefractionRad(RadFromDeg(-1.0), {}), RadFromDeg(0.5));  // The disc is not gone yet.
}

TEST(RefractionHardCases, DirectionIsContinuousThroughTheZenith) {
  const Atmosphere air;
  EXPECT_EQ(ApparentDirection({0.0, 0.0, 1.0}, air), glm::dvec3(0.0, 0.0, 1.0));
  EXPECT_EQ(ApparentDirection({0.0, 0.0, -1.0}, air), glm::dvec3(0.0, 0.0, -1.0));
  for (double offset = 1.0; offset > 1e-200; offset *= 1e-3) {
    const glm::dvec3 near = ApparentDirection({offset, 0.3 * offset, 1.0}, air);
    EXPECT_NEAR(glm::length(near), 1.0, 1e-12);
    // On its own side of the zenith, and no farther from it than it was.
    EXPECT_GE(near.x, 0.0);
    EXPECT_LE(near.x, offset);
    EXPECT_NEAR(near.x, offset / std::hypot(1.0, offset, 0.3 * offset), 4e-4 * offset + 1e-15);
  }
}

TEST(RefractionHardCases, NadirAndHorizonKeepUnitLength) {
  const Atmosphere air{1200.0, -150.0};
  for (double elevation_deg = -90.0; elevation_deg <= 90.0; elevation_deg += 0.25) {
    for (double azimuth_deg = 0.0; azimuth_deg < 360.0; azimuth_deg += 30.0) {
      const glm::dvec3 lifted =
          ApparentDirection(DirectionFromDegrees(azimuth_deg, elevation_deg), air);
      EXPECT_NEAR(glm::length(lifted), 1.0, 1e-12);
    }
  }
}

TEST(RefractionHardCases, StandardAtmosphereIsSaneFromTheDeadSeaToOrbit) {
  EXPECT_NEAR(StandardAtmosphere(-430.0).pressure_hpa, 1066.0, 1.0);
  EXPECT_NEAR(StandardAtmosphere(8848.0).pressure_hpa, 315.0, 2.0);
  double before_hpa = std::numeric_limits<double>::infinity();
  for (double height_m = -500.0; height_m <= 400e3; height_m += 50.0) {
    const Atmosphere air = StandardAtmosphere(height_m);
    air.Validate();
    ASSERT_GT(air.pressure_hpa, 0.0) << height_m;
    ASSERT_LT(air.pressure_hpa, before_hpa) << height_m;
    ASSERT_GT(air.temperature_c, -57.0);
    before_hpa = air.pressure_hpa;
  }
  EXPECT_LT(RefractionRad(0.0, StandardAtmosphere(400e3)), 1e-15);
}

// The formula's least value is 0.016 deg off the zenith: it rises by 1e-6 a step there.
TEST(RefractionHardCases, AirMassIsPositiveAndFallingEverywhere) {
  double before = std::numeric_limits<double>::infinity();
  for (double elevation_deg = -90.0; elevation_deg <= 90.0; elevation_deg += 0.01) {
    const double air_mass = RelativeAirMass(RadFromDeg(std::min(elevation_deg, 90.0)));
    ASSERT_GE(air_mass, 0.999);
    ASSERT_LE(air_mass, 40.0);
    ASSERT_LE(air_mass, before + 1e-6);
    before = air_mass;
  }
}

TEST(RefractionHardCases, RefusesBadInputByName) {
  EXPECT_THAT(ErrorOf([] { RefractionRad(kNan, {}); }), HasSubstr("airless_elevation_rad is nan"));
  EXPECT_THAT(ErrorOf([] { RefractionRad(39.8, {}); }), HasSubstr("airless_elevation_rad is 39.8"));
  EXPECT_THAT(ErrorOf([] { RefractionRad(0.1, {kNan, 0.0}); }), HasSubstr("pressure_hpa is nan"));
  EXPECT_THAT(ErrorOf([] { RefractionRad(0.1, {-1.0, 0.0}); }), HasSubstr("pressure_hpa is -1"));
  EXPECT_THAT(ErrorOf([] {
                RefractionRad(0.1, {101325.0, 0.0});
              }),
              HasSubstr("pressure_hpa is 101325"));
  EXPECT_THAT(ErrorOf([] {
                RefractionRad(0.1, {1000.0, -273.0});
              }),
              HasSubstr("temperature_c is -273"));
  EXPECT_THAT(ErrorOf([] {
                RefractionRad(0.1, {1000.0, 288.0});
              }),
              HasSubstr("temperature_c is 288"));
  EXPECT_THAT(ErrorOf([] { RelativeAirMass(kNan); }), HasSubstr("apparent_elevation_rad is nan"));
  EXPECT_THAT(ErrorOf([] { StandardAtmosphere(kNan); }), HasSubstr("height_m is nan"));
  EXPECT_THAT(ErrorOf([] { StandardAtmosphere(-6356766.0); }), HasSubstr("height_m is -6356766"));
  EXPECT_THAT(ErrorOf([] {
                ApparentDirection({0.0, 0.0, 0.0}, {});
              }),
              HasSubstr("airless_direction_enu"));
  EXPECT_THAT(ErrorOf([] {
                ApparentDirection({kNan, 0.0, 0.0}, {});
              }),
              HasSubstr("airless_direction_enu"));
}

}  // namespace
}  // namespace pleinair::refraction_hard_cases_test

#include "sunmodel/north.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sunmodel/angles.h"

namespace pleinair::north_test {
namespace {

using namespace std::chrono_literals;

constexpr Site SiteAt(double latitude_deg, double longitude_deg) {
  return {RadFromDeg(latitude_deg), RadFromDeg(longitude_deg), 0.0};
}

TEST(GridNorth, IsTrueNorthOnTheZonesMiddleMeridian) {
  EXPECT_NEAR(GridNorthAzimuthRad(SiteAt(50.0, 9.0)), 0.0, 1e-12);
  EXPECT_NEAR(GridNorthAzimuthRad(SiteAt(-33.0, 15.0)), 0.0, 1e-12);
}

// On the sphere tan(convergence) = tan(longitude from the middle meridian) sin(latitude); the
// ellipsoid adds up to 0.003 deg within a zone (Redfearn's second term).
TEST(GridNorth, FollowsTheClosedFormOfTheSphere) {
  for (const double latitude_deg : {-60.0, -10.0, 35.0, 57.0488, 75.0}) {
    for (const double from_middle_deg : {-2.9, -1.0, 0.9217, 2.9}) {
      const double expected_rad =
          std::atan(std::tan(RadFromDeg(from_middle_deg)) * std::sin(RadFromDeg(latitude_deg)));
      EXPECT_NEAR(GridNorthAzimuthRad(SiteAt(latitude_deg, 15.0 + from_middle_deg)),
                  expected_rad,
                  RadFromDeg(0.003))
          << latitude_deg << " " << from_middle_deg;
    }
  }
}

TEST(GridNorth, RefusesASiteThatIsNone) {
  EXPECT_THROW(GridNorthAzimuthRad(SiteAt(95.0, 0.0)), std::invalid_argument);
  EXPECT_THROW(GridNorthAzimuthRad(SiteAt(std::numeric_limits<double>::quiet_NaN(), 0.0)),
               std::invalid_argument);
}

TEST(MagneticNorth, SaysWhichModelIsNotThereAndWhere) {
  const UtcTime time = std::chrono::sys_days{std::chrono::year(2021) / 6 / 1};
  try {
    MagneticNorthAzimuthRad(SiteAt(50.0, 9.0), time, {"no-such-model", "no-such-folder"});
    FAIL() << "expected an error";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("no-such-model in no-such-folder"));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

TEST(TurnedClockwise, TurnsNorthToEastAndKeepsHeight) {
  const glm::dvec3 turned = TurnedClockwise({0.0, 0.6, 0.8}, RadFromDeg(90.0));
  EXPECT_NEAR(turned.x, 0.6, 1e-15);
  EXPECT_NEAR(turned.y, 0.0, 1e-15);
  EXPECT_EQ(turned.z, 0.8);
}

}  // namespace
}  // namespace pleinair::north_test

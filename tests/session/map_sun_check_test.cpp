// A survey map's own sun against a stated or computed one.
#include "session/map_sun_check.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scene/lat_long.h"

namespace pleinair::map_sun_check_test {
namespace {

constexpr LatLongSize kSize{512, 256};

glm::dvec3 Direction(double azimuth_deg, double elevation_deg) {
  const double azimuth = RadFromDeg(azimuth_deg);
  const double elevation = RadFromDeg(elevation_deg);
  return {std::cos(elevation) * std::sin(azimuth),
          std::cos(elevation) * std::cos(azimuth),
          std::sin(elevation)};
}

// Under an even sky; the disc in one pixel of 0.7 deg.
RgbImage MapWithSun(const glm::dvec3& to_sun) {
  RgbImage map(kSize.width, kSize.height, glm::vec3(1.0f));
  const glm::ivec2 at = LatLongPixelFromDirection(to_sun, kSize);
  map.At(at.x, at.y) = glm::vec3(1e5f);
  return map;
}

TEST(CompareWithMapSun, IsSilentWhereTheyAgreeOrNoSunIsShown) {
  const glm::dvec3 sun = Direction(150.0, 40.0);
  EXPECT_FALSE(CompareWithMapSun(MapWithSun(sun), sun));
  EXPECT_FALSE(CompareWithMapSun(MapWithSun(sun), Direction(151.0, 41.0)));
  const RgbImage even(kSize.width, kSize.height, glm::vec3(1.0f));
  EXPECT_FALSE(CompareWithMapSun(even, sun));
}

// A north that is 10 deg off moves a sun 75 deg high by 2.6 deg, and turns shadows by 10.
TEST(CompareWithMapSun, SeesAWrongNorthUnderAHighSun) {
  const auto found = CompareWithMapSun(MapWithSun(Direction(170.0, 75.0)), Direction(180.0, 75.0));
  ASSERT_TRUE(found);
  EXPECT_LT(found->angle_rad, kWorthAWarningRad);
  EXPECT_NEAR(DegFromRad(found->turn_rad), 10.0, 1.5);
  // Within what is uncertain of north.
  EXPECT_FALSE(CompareWithMapSun(
      MapWithSun(Direction(170.0, 75.0)), Direction(180.0, 75.0), RadFromDeg(14.0)));
}

// At the zenith a pixel is any azimuth.
TEST(CompareWithMapSun, ComparesNoAzimuthAtTheZenith) {
  EXPECT_FALSE(CompareWithMapSun(MapWithSun(Direction(90.0, 89.6)), Direction(270.0, 89.6)));
}

}  // namespace
}  // namespace pleinair::map_sun_check_test

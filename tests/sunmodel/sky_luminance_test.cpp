#include "sunmodel/sky_luminance.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "sunmodel/angles.h"

namespace pleinair::sky_luminance_test {
namespace {

glm::dvec3 Direction(double azimuth_deg, double elevation_deg) {
  const double azimuth = RadFromDeg(azimuth_deg);
  const double elevation = RadFromDeg(elevation_deg);
  return {std::sin(azimuth) * std::cos(elevation),
          std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

// Share of the horizontal irradiance that a vertical wall facing `azimuth_deg` gets, by summing
// over 1 deg cells: good to 1e-3.
template <typename Radiance>
double WallShare(const Radiance& radiance, double azimuth_deg) {
  const glm::dvec3 normal = Direction(azimuth_deg, 0.0);
  double wall = 0.0;
  double level = 0.0;
  for (double elevation = 0.5; elevation < 90.0; elevation += 1.0) {
    for (double azimuth = 0.5; azimuth < 360.0; azimuth += 1.0) {
      const glm::dvec3 direction = Direction(azimuth, elevation);
      const double light = radiance(direction) * std::cos(RadFromDeg(elevation));
      wall += light * std::max(0.0, glm::dot(direction, normal));
      level += light * direction.z;
    }
  }
  return wall / level;
}

TEST(OvercastSky, IsThreeTimesAsBrightAtTheZenithAsAtTheHorizon) {
  EXPECT_DOUBLE_EQ(OvercastSkyLuminance({0.0, 0.0, 1.0}), 1.0);
  EXPECT_NEAR(OvercastSkyLuminance(Direction(77.0, 1e-9)), 1.0 / 3.0, 1e-9);
  EXPECT_EQ(OvercastSkyLuminance(Direction(77.0, -1.0)), 0.0);
}

// (pi / 6 + 4 / 9) / (7 pi / 9), from integrating (1 + 2 sin e) cos^2 e over half the azimuths.
TEST(OvercastSky, GivesAWallTwoFifthsOfTheLevelGroundsLight) {
  const double expected = (std::numbers::pi / 6.0 + 4.0 / 9.0) / (7.0 * std::numbers::pi / 9.0);
  EXPECT_NEAR(expected, 0.396, 5e-4);
  EXPECT_NEAR(WallShare(OvercastSkyLuminance, 30.0), expected, 1e-3);
}

// More than the uniform sky's 0.5 on the mean of all sides, and most of it towards the sun.
TEST(ClearSky, GivesWallsMoreThanAnOvercastSkyAndMostTowardsTheSun) {
  const ClearSkyDistribution sky(Direction(135.0, 40.0));
  const auto green = [&](const glm::dvec3& direction) { return sky.Radiance(direction).y; };
  const double to_sun = WallShare(green, 135.0);
  const double from_sun = WallShare(green, 315.0);
  const double across = WallShare(green, 45.0);
  EXPECT_GT(to_sun, 1.5 * from_sun);
  EXPECT_GT(0.25 * (to_sun + from_sun + 2.0 * across), 0.55);
}

// Air alone, thin, the sun overhead: radiance goes with the Rayleigh phase function times the path,
// 3/4 (1 + cos^2) / cos, here against that formula. 6 %: the red band's depth of 0.06 dims slant
// paths.
TEST(ClearSky, IsThatOfThinAirWithoutHaze) {
  const ClearSkyDistribution sky({0.0, 0.0, 1.0}, 0.0);
  const double zenith = sky.Radiance({0.0, 0.0, 1.0}).x / 1.5;
  for (double elevation = 30.0; elevation < 90.0; elevation += 10.0) {
    const double cosine = std::sin(RadFromDeg(elevation));
    const double expected = zenith * 0.75 * (1.0 + cosine * cosine) / cosine;
    EXPECT_NEAR(sky.Radiance(Direction(50.0, elevation)).x, expected, 0.06 * expected);
  }
}

// Haze scatters forward: the ring around the sun is brighter against the rest of the sky.
TEST(ClearSky, IsTheBrighterAroundTheSunTheHazierItIs) {
  double last = 0.0;
  for (const double depth : {0.0, 0.05, 0.2, 0.8}) {
    const ClearSkyDistribution sky(Direction(180.0, 50.0), depth);
    const double ratio =
        sky.Radiance(Direction(180.0, 54.0)).y / sky.Radiance(Direction(0.0, 54.0)).y;
    EXPECT_GT(ratio, 1.2 * last) << depth;
    last = ratio;
  }
}

// Air scatters blue most, and long paths lose it again: the zenith is blue, the horizon paler.
TEST(ClearSky, IsBlueOverheadAndPalerAtTheHorizon) {
  const ClearSkyDistribution sky(Direction(180.0, 45.0));
  const glm::dvec3 zenith = sky.Radiance({0.0, 0.0, 1.0});
  const glm::dvec3 horizon = sky.Radiance(Direction(0.0, 2.0));
  EXPECT_GT(zenith.z, 1.5 * zenith.x);
  EXPECT_LT(horizon.z / horizon.x, 0.75 * zenith.z / zenith.x);
}

TEST(ClearSky, IsDarkestFarFromTheSun) {
  const ClearSkyDistribution sky(Direction(180.0, 30.0));
  EXPECT_GT(sky.Radiance(Direction(180.0, 31.0)).y, 4.0 * sky.Radiance(Direction(0.0, 60.0)).y);
}

// Turning the sun turns the sky.
TEST(ClearSky, TurnsWithTheSun) {
  const ClearSkyDistribution sky(Direction(100.0, 25.0));
  const ClearSkyDistribution turned(Direction(170.0, 25.0));
  for (double azimuth = 0.0; azimuth < 360.0; azimuth += 30.0) {
    const glm::dvec3 before = sky.Radiance(Direction(azimuth, 35.0));
    const glm::dvec3 after = turned.Radiance(Direction(azimuth + 70.0, 35.0));
    EXPECT_NEAR(before.y, after.y, 1e-12 * before.y);
  }
}

// The sun a hundredth of a degree on: the sky against its zenith, too, by less than five
// thousandths. Its steepest slope, beside the sun, is some 10 % a degree; on the horizon the sun's
// light dims by 2 % in a hundredth of a degree, and where it is scattered low by a few thousandths
// less than overhead. Through the zenith and the horizon.
TEST(ClearSkyHardCases, IsContinuousInTheSunThroughZenithAndHorizon) {
  const glm::dvec3 kZenith(0.0, 0.0, 1.0);
  const auto expect_close = [&](const glm::dvec3& sun, const glm::dvec3& next) {
    const ClearSkyDistribution a(sun);
    const ClearSkyDistribution b(next);
    for (double elevation = 1.0; elevation < 90.0; elevation += 11.0) {
      for (double azimuth = 0.0; azimuth < 360.0; azimuth += 45.0) {
        const glm::dvec3 direction = Direction(azimuth, elevation);
        const double scale = a.Radiance(direction).y / a.Radiance(kZenith).y;
        EXPECT_NEAR(scale, b.Radiance(direction).y / b.Radiance(kZenith).y, 5e-3 * scale);
      }
    }
  };
  expect_close(Direction(0.0, 89.995), Direction(180.0, 89.995));
  expect_close(Direction(60.0, 0.005), Direction(60.0, -0.005));
  expect_close(Direction(60.0, -0.005), Direction(60.0, -5.0));
}

TEST(ClearSkyHardCases, IsFiniteAndNotNegativeForEverySun) {
  for (double sun_elevation = -90.0; sun_elevation <= 90.0; sun_elevation += 7.5) {
    for (const double depth : {0.0, 0.084, 5.0}) {
      const ClearSkyDistribution sky(Direction(10.0, sun_elevation), depth);
      for (double elevation = 1e-6; elevation <= 90.0; elevation += 9.0) {
        for (double azimuth = 10.0; azimuth < 370.0; azimuth += 60.0) {
          const glm::dvec3 radiance = sky.Radiance(Direction(azimuth, elevation));
          for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(std::isfinite(radiance[c])) << sun_elevation << " " << elevation;
            EXPECT_GE(radiance[c], 0.0);
          }
          EXPECT_GT(radiance.y, 0.0) << sun_elevation << " " << elevation;
        }
      }
      EXPECT_EQ(sky.Radiance(Direction(10.0, -1.0)), glm::dvec3(0.0));
    }
  }
}

TEST(ClearSkyHardCases, RefusesWhatIsNoDirectionAndNoDepth) {
  EXPECT_THROW(ClearSkyDistribution({0.0, 0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(ClearSkyDistribution({NAN, 0.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(ClearSkyDistribution({0.0, 0.0, 1.0}, -0.1), std::invalid_argument);
  EXPECT_THROW(ClearSkyDistribution({0.0, 0.0, 1.0}, NAN), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::sky_luminance_test

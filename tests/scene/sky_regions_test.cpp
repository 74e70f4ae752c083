#include "scene/sky_regions.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/sky_shape.h"
#include "tests/scene/region_light.h"

namespace pleinair::sky_regions_test {
namespace {

glm::dvec3 Direction(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
  const double elevation = elevation_deg * std::numbers::pi / 180.0;
  return {std::sin(azimuth) * std::cos(elevation),
          std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

TEST(SkyRegions, NumbersThemFromNorthClockwiseAndFromTheHorizonUp) {
  const SkyRegions regions;
  ASSERT_EQ(regions.Count(), 64u);
  EXPECT_EQ(regions.RegionOf(Direction(1.0, 1.0)), 0u);
  EXPECT_EQ(regions.RegionOf(Direction(22.4, 1.0)), 0u);
  EXPECT_EQ(regions.RegionOf(Direction(22.6, 1.0)), 1u);
  EXPECT_EQ(regions.RegionOf(Direction(91.0, 1.0)), 4u);
  EXPECT_EQ(regions.RegionOf(Direction(359.0, 1.0)), 15u);
  // Bands end where the sine of the elevation is 1/4, 1/2, 3/4.
  EXPECT_EQ(regions.RegionOf(Direction(1.0, 14.4)), 0u);
  EXPECT_EQ(regions.RegionOf(Direction(1.0, 14.6)), 16u);
  EXPECT_EQ(regions.RegionOf(Direction(1.0, 30.1)), 32u);
  EXPECT_EQ(regions.RegionOf(Direction(1.0, 89.0)), 48u);
}

TEST(SkyRegions, HasNoneOnAndBelowTheHorizon) {
  const SkyRegions regions;
  EXPECT_FALSE(regions.RegionOf({1.0, 0.0, 0.0}).has_value());
  EXPECT_FALSE(regions.RegionOf({0.0, 0.6, -0.8}).has_value());
  EXPECT_TRUE(regions.RegionOf({0.0, 0.0, 1.0}).has_value());
}

// The hemisphere has 2 pi steradians, and a white one gives a level plane pi.
TEST(SkyRegions, SolidAnglesAndIrradiancesAddUpToTheHemispheres) {
  for (const auto& [bands, sectors] : std::vector<std::pair<int, int>>{{1, 1}, {4, 16}, {7, 3}}) {
    const SkyRegions regions(bands, sectors);
    double irradiance = 0.0;
    for (std::size_t region = 0; region < regions.Count(); ++region) {
      irradiance += HorizontalIrradiance(regions, region);
    }
    EXPECT_NEAR(irradiance, std::numbers::pi, 1e-12);
    EXPECT_NEAR(regions.SolidAngleSr() * static_cast<double>(regions.Count()),
                2.0 * std::numbers::pi,
                1e-12);
  }
}

// A second way: cells of equal solid angle, counted. 4 %: of some 800 a region, 60 lie along its
// borders with axis-parallel sectors, where whole rows fall to one side.
TEST(SkyRegions, AreOfEqualSolidAngle) {
  const SkyRegions regions;
  std::vector<double> solid_angle(regions.Count(), 0.0);
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    const double weight = SkyTable::SolidAngleSr(cell);
    if (weight > 0.0) solid_angle[*regions.RegionOf(SkyTable::DirectionOfCell(cell))] += weight;
  }
  for (const double found : solid_angle) {
    EXPECT_NEAR(found, regions.SolidAngleSr(), 0.04 * regions.SolidAngleSr());
  }
}

TEST(SkyRegions, DirectionsInARegionLieInIt) {
  const SkyRegions regions(3, 5);
  for (std::size_t region = 0; region < regions.Count(); ++region) {
    for (const double x : {0.01, 0.5, 0.99}) {
      for (const double y : {0.01, 0.5, 0.99}) {
        const glm::dvec3 direction = regions.DirectionIn(region, {x, y});
        EXPECT_NEAR(glm::length(direction), 1.0, 1e-12);
        EXPECT_EQ(regions.RegionOf(direction), region);
      }
    }
  }
}

TEST(SkyRegionsHardCases, EveryDirectionAboveTheHorizonHasOne) {
  const SkyRegions regions;
  // 1e-300 to the west of north, and 1e-17 to the west of the zenith.
  EXPECT_EQ(regions.RegionOf({-1e-300, 0.9, 0.1}), 15u);
  EXPECT_TRUE(regions.RegionOf({-1e-17, 1e-17, 1.0}).has_value());
  EXPECT_EQ(regions.RegionOf({0.0, 1.0, 1e-300}), 0u);
}

TEST(SkyRegionsHardCases, RefusesNoneAndTooMany) {
  EXPECT_THROW(SkyRegions(0, 16), std::invalid_argument);
  EXPECT_THROW(SkyRegions(4, -1), std::invalid_argument);
  EXPECT_THROW(SkyRegions(1 << 16, 1 << 16), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::sky_regions_test

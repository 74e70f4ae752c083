#include "sunmodel/sky_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "sunmodel/sky_luminance.h"
#include "tests/scene/irradiance_by_points.h"

namespace pleinair::sky_shapes_test {
namespace {

using testing::IrradianceByPoints;

// 2e-3: the clear sky's table has cells of half a degree, whose means its centres stand for.
TEST(SkyShapes, EveryKindBringsIrradianceOneInEveryChannel) {
  for (const glm::dvec3& sun : {glm::dvec3(0.0, -0.6, 0.8), glm::dvec3(0.98, 0.0, 0.199)}) {
    for (const SkyShapeKind kind : kAllSkyShapeKinds) {
      const auto shape = MakeSkyShape(kind, sun);
      EXPECT_EQ(shape->Name(), NameOf(kind));
      const glm::dvec3 irradiance = IrradianceByPoints(*shape, 20000);
      for (int channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(irradiance[channel], 1.0, 2e-3) << shape->Name();
      }
      EXPECT_EQ(shape->Radiance({0.0f, 0.8f, -0.6f}), glm::vec3(0.0f));
    }
  }
}

TEST(SkyShapes, WhatIsSaidToBeLinearInHeightIsSo) {
  int linear = 0;
  for (const SkyShapeKind kind : kAllSkyShapeKinds) {
    const auto shape = MakeSkyShape(kind, glm::normalize(glm::dvec3(0.3, -0.8, 0.5)));
    const auto by_height = shape->LinearInHeight();
    if (!by_height) continue;
    ++linear;
    for (int i = 1; i <= 200; ++i) {
      const double rise = 0.005 * i;
      const double level = std::sqrt(std::max(1.0 - rise * rise, 0.0));
      const glm::dvec3 direction(level * std::cos(2.4 * i), level * std::sin(2.4 * i), rise);
      const glm::vec3 radiance = shape->Radiance(glm::vec3(direction));
      EXPECT_NEAR(radiance.x, by_height->level + by_height->rise * rise, 1e-6) << shape->Name();
      EXPECT_EQ(radiance, glm::vec3(radiance.x));
    }
  }
  EXPECT_EQ(linear, 2);
}

// The table's cells are 0.45 deg wide; beside the sun the sky changes by some 15 % a degree.
TEST(SkyShapes, TheClearShapeFollowsItsModelClosely) {
  const glm::dvec3 sun = glm::normalize(glm::dvec3(0.3, -0.8, 0.5));
  const auto shape = MakeClearSkyShape(sun);
  const ClearSkyDistribution model(sun);
  const glm::vec3 zenith(0.0f, 0.0f, 1.0f);
  const double scale = shape->Radiance(zenith).y / model.Radiance(glm::dvec3(zenith)).y;
  for (double azimuth = 0.0; azimuth < 6.28; azimuth += 0.37) {
    for (double elevation = 0.03; elevation < 1.57; elevation += 0.11) {
      const glm::dvec3 direction(std::sin(azimuth) * std::cos(elevation),
                                 std::cos(azimuth) * std::cos(elevation),
                                 std::sin(elevation));
      const double expected = scale * model.Radiance(direction).y;
      EXPECT_NEAR(shape->Radiance(glm::vec3(direction)).y, expected, 0.05 * expected);
    }
  }
}

}  // namespace
}  // namespace pleinair::sky_shapes_test

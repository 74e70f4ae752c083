#include "scene/sky_shape.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/lat_long.h"
#include "tests/scene/irradiance_by_points.h"

namespace pleinair::sky_shape_test {
namespace {

using testing::IrradianceByPoints;

// Brighter to the south and low down, another slope in each channel.
RgbImage SlopedSky(int width, int height) {
  RgbImage sky(width, height, glm::vec3(0.0f));
  for (int y = 0; y < height / 2; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::dvec3 d = DirectionFromLatLong({x + 0.5, y + 0.5}, {width, height});
      sky.At(x, y) = glm::vec3(2.0 - d.y, 3.0 - 2.0 * d.z, 1.0 + 0.5 * d.x * d.z);
    }
  }
  return sky;
}

TEST(SkyShape, UniformSkyIsOneOverPiAboveTheHorizonAndDarkBelow) {
  const auto sky = MakeUniformSkyShape();
  EXPECT_EQ(sky->Name(), "uniform");
  EXPECT_FLOAT_EQ(sky->Radiance({0.0f, 0.0f, 1.0f}).x, std::numbers::inv_pi_v<float>);
  EXPECT_EQ(sky->Radiance({1.0f, 0.0f, 0.0f}), glm::vec3(0.0f));
  EXPECT_EQ(sky->Radiance({0.0f, 0.6f, -0.8f}), glm::vec3(0.0f));
}

// 1e-3: the points' own error for a smooth sky is some 1 / points, the rest is the interpolated
// image's kinks at its pixels' centres.
TEST(SkyShape, AnImageBringsIrradianceOneInEveryChannel) {
  for (const LatLongSize size : {LatLongSize{64, 32}, LatLongSize{256, 128}}) {
    const auto shape = MakeImageSkyShape("image", SlopedSky(size.width, size.height));
    const glm::dvec3 irradiance = IrradianceByPoints(*shape, 20000);
    for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(irradiance[channel], 1.0, 1e-3);
  }
}

// Rows are at elevations e with equal steps; the midpoint rule over 64 of them is off by 2e-4.
TEST(SkyShape, IrradianceOfAWhiteSkyIsPi) {
  const RgbImage white(128, 64, glm::vec3(1.0f));
  EXPECT_NEAR(HorizontalIrradiance(white).y, std::numbers::pi, 2e-4 * std::numbers::pi);
}

TEST(SkyShape, WhatLiesBelowTheHorizonIsNotLookedAt) {
  RgbImage sky = SlopedSky(64, 32);
  const auto clean = MakeImageSkyShape("clean", sky);
  for (int y = 16; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) sky.At(x, y) = glm::vec3(1000.0f);
  }
  const auto with_ground = MakeImageSkyShape("with ground", sky);
  const glm::vec3 low = glm::normalize(glm::vec3(0.3f, 0.9f, 0.01f));
  EXPECT_EQ(clean->Radiance(low), with_ground->Radiance(low));
  EXPECT_GT(clean->Radiance(low).x, 0.0f);
}

TEST(SkyShapeHardCases, ABlackChannelHasNoLight) {
  RgbImage sky(64, 32, glm::vec3(1.0f, 0.0f, 2.0f));
  const glm::vec3 up = MakeImageSkyShape("red and blue", sky)->Radiance({0.0f, 0.0f, 1.0f});
  EXPECT_NEAR(up.x, std::numbers::inv_pi, 1e-4);
  EXPECT_EQ(up.y, 0.0f);
  EXPECT_NEAR(up.z, std::numbers::inv_pi, 1e-4);
}

TEST(SkyShapeHardCases, ShapeDoesNotDependOnTheImagesScale) {
  RgbImage sky = SlopedSky(64, 32);
  const auto reference = MakeImageSkyShape("reference", sky);
  const glm::vec3 direction = glm::normalize(glm::vec3(0.5f, -0.4f, 0.3f));
  for (const float scale : {1e-12f, 1e12f}) {
    RgbImage scaled = sky;
    for (glm::vec3& pixel : scaled.pixels) pixel *= scale;
    const glm::vec3 value = MakeImageSkyShape("scaled", scaled)->Radiance(direction);
    EXPECT_NEAR(value.x, reference->Radiance(direction).x, 1e-5);
  }
}

TEST(SkyShapeHardCases, RefusesImagesWithDefects) {
  for (const float bad :
       {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    RgbImage sky = SlopedSky(64, 32);
    sky.At(5, 3).y = bad;
    EXPECT_THROW(MakeImageSkyShape("bad", sky), std::invalid_argument);
  }
  EXPECT_THROW(MakeImageSkyShape("empty", RgbImage{}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::sky_shape_test

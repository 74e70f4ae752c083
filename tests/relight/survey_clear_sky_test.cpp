#include "relight/survey/internal/survey_clear_sky.h"

#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/lat_long.h"
#include "scene/sky_shape.h"
#include "sunmodel/sky_luminance.h"

namespace pleinair::survey_clear_sky_test {
namespace {

const glm::dvec3 kSunEnu = glm::normalize(glm::dvec3(0.5, -0.6, 0.7));
constexpr LatLongSize kSize{256, 128};

struct MadeUpSky {
  double depth = 0.0;
  double clear = 1.0;  // Each relative to the clear sky's zenith.
  double uniform = 0.3;
  double overcast = 0.0;
  double clouds = 0.0;  // Share of the sky that a bright cloud covers.
  double noise = 0.02;  // Relative.
};

RgbImage MakeSky(const MadeUpSky& made) {
  const ClearSkyDistribution clear(kSunEnu, made.depth);
  const glm::dvec3 zenith = clear.Radiance({0.0, 0.0, 1.0});
  RgbImage sky(kSize.width, kSize.height);
  std::uint32_t state = 1;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / (1u << 24) - 0.5;
  };
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width; ++x) {
      const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, kSize);
      glm::dvec3 radiance = made.clear * clear.Radiance(direction) / zenith;
      radiance += made.uniform + made.overcast * OvercastSkyLuminance(direction);
      // Patches some 20 degrees wide.
      const bool cloud =
          std::sin(9.0 * direction.x + 1.0) * std::sin(8.0 * direction.y) > 1.0 - 2.0 * made.clouds;
      if (cloud) radiance += glm::dvec3(2.0);
      sky.At(x, y) = glm::vec3(radiance * (1.0 + 3.46 * made.noise * random()));
    }
  }
  return sky;
}

Gray8Image UpperHemisphere() {
  Gray8Image shows_sky(kSize.width, kSize.height, 0);
  for (int y = 0; y < kSize.height / 2; ++y) {
    for (int x = 0; x < kSize.width; ++x) shows_sky.At(x, y) = 255;
  }
  return shows_sky;
}

TEST(SurveyClearSky, ItsHazeIsFoundBetweenCloudsAndThinVeils) {
  for (const double depth : {0.0, kStandardAerosolDepth500nm, 0.27}) {
    for (const double clouds : {0.0, 0.2}) {
      const auto found =
          MeasureClearSky(MakeSky({.depth = depth, .clouds = clouds}), UpperHemisphere(), kSunEnu);
      ASSERT_TRUE(found);
      // To the next step of the depths that are tried.
      EXPECT_GE(found->aerosol_optical_depth_500nm, 0.6 * depth) << depth << " " << clouds;
      EXPECT_LE(found->aerosol_optical_depth_500nm, 1.5 * depth + 0.01) << depth << " " << clouds;
    }
  }
}

// Clouds add a seventh.
TEST(SurveyClearSky, ItsLightIsFoundBetweenClouds) {
  const glm::dvec3 cloudless = HorizontalIrradiance(MakeSky({}));
  const RgbImage cloudy = MakeSky({.clouds = 0.2});
  const auto found = MeasureClearSky(cloudy, UpperHemisphere(), kSunEnu);
  ASSERT_TRUE(found && found->irradiance_rgb);
  for (int c = 0; c < 3; ++c) {
    EXPECT_GT(HorizontalIrradiance(cloudy)[c], 1.1 * cloudless[c]);
    EXPECT_NEAR((*found->irradiance_rgb)[c], cloudless[c], 0.05 * cloudless[c]);
  }
}

TEST(SurveyClearSky, ItsLightIsNotClaimedWhereMostOfTheSkyIsSomethingElse) {
  RgbImage sky = MakeSky({.clouds = 0.5});
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width / 3; ++x) sky.At(x, y) *= 0.3f;  // A wall that the mesh lacks.
  }
  const auto found = MeasureClearSky(sky, UpperHemisphere(), kSunEnu);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->irradiance_rgb);
}

// The share of it that a survey's walls leave is enough.
TEST(SurveyClearSky, IsFoundInPartOfTheSky) {
  Gray8Image shows_sky = UpperHemisphere();
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width / 2; ++x) shows_sky.At(x, y) = 0;
  }
  RgbImage sky = MakeSky({.depth = 0.0});
  for (int y = 0; y < kSize.height; ++y) {
    for (int x = 0; x < kSize.width / 2; ++x) sky.At(x, y) = glm::vec3(50.0f);  // A wall.
  }
  const auto found = MeasureClearSky(sky, shows_sky, kSunEnu);
  ASSERT_TRUE(found && found->irradiance_rgb);
  EXPECT_EQ(found->aerosol_optical_depth_500nm, 0.0);
  const glm::dvec3 whole = HorizontalIrradiance(MakeSky({.depth = 0.0}));
  EXPECT_NEAR(found->irradiance_rgb->y, whole.y, 0.05 * whole.y);
}

TEST(SurveyClearSky, ItsHazeIsTheStandardOneWhereTheSkyDoesNotDetermineIt) {
  const MadeUpSky overcast{.clear = 0.0, .uniform = 0.0, .overcast = 1.0};
  const auto found = MeasureClearSky(MakeSky(overcast), UpperHemisphere(), kSunEnu);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->aerosol_optical_depth_500nm, kStandardAerosolDepth500nm);
}

TEST(SurveyClearSkyHardCases, IsUnknownWithoutSkyWithoutSunAndAtNight) {
  const RgbImage sky = MakeSky({});
  EXPECT_FALSE(MeasureClearSky(sky, Gray8Image(kSize.width, kSize.height, 0), kSunEnu));
  EXPECT_FALSE(MeasureClearSky(sky, UpperHemisphere(), {0.0, 1.0, 0.0}));
  EXPECT_FALSE(MeasureClearSky(
      RgbImage(kSize.width, kSize.height, glm::vec3(0.0f)), UpperHemisphere(), kSunEnu));
}

}  // namespace
}  // namespace pleinair::survey_clear_sky_test

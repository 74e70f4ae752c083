// Light that lost a channel, and light as daylight is.
#include "pipeline/daylight_colours.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sunmodel/angles.h"
#include "sunmodel/clear_sky.h"

namespace pleinair::daylight_colours_test {
namespace {

Lighting LightOf(const glm::dvec3& sun,
                 const glm::dvec3& uniform,
                 const glm::dvec3& clear,
                 double elevation_deg = 45.0) {
  Lighting lighting;
  const double elevation = RadFromDeg(elevation_deg);
  lighting.sun.direction_enu = {std::cos(elevation), 0.0, std::sin(elevation)};
  lighting.sun.irradiance_rgb = sun;
  lighting.sky = {{"uniform", uniform}, {"clear", clear}};
  return lighting;
}

TEST(DaylightColours, OfDaylightAreLeftAlone) {
  // Noon, by other white balances too; overcast, dusk, darkness, a red sun at the horizon, and an
  // overcast sky's sun that is not quite 0.
  for (const glm::dvec3 balance : {glm::dvec3(1.0), glm::dvec3(1.5, 1.0, 0.7), {0.8, 1.0, 1.2}}) {
    EXPECT_FALSE(WithDaylightColours(LightOf(balance * glm::dvec3(900, 850, 700),
                                             balance * glm::dvec3(60, 80, 120),
                                             balance * glm::dvec3(10, 20, 40))));
  }
  EXPECT_FALSE(WithDaylightColours(LightOf({0, 0, 0}, {90, 95, 100}, {0, 0, 0})));
  EXPECT_FALSE(WithDaylightColours(LightOf({0, 0, 0}, {0, 0, 0}, {3, 5, 10}, -3.0)));
  EXPECT_FALSE(WithDaylightColours(LightOf({0, 0, 0}, {0, 0, 0}, {0, 0, 0})));
  EXPECT_FALSE(WithDaylightColours(LightOf({30, 7, 0.3}, {9, 10, 12}, {0, 0, 0}, 0.5)));
  EXPECT_FALSE(WithDaylightColours(LightOf({1, 0, 0}, {90, 95, 100}, {0, 0, 0})));
}

// Colours of the model's clear skies, from clear air to thick haze.
TEST(DaylightColours, OfClearSkiesAreLeftAlone) {
  for (const double haze : {0.03, 0.084, 0.2, 0.35}) {
    for (const double elevation_deg : {8.0, 12.0, 20.0, 30.0, 45.0, 60.0, 80.0}) {
      const ClearSkyIrradiance sky =
          ComputeClearSky({}, RadFromDeg(elevation_deg), {.aerosol_optical_depth_500nm = haze});
      EXPECT_FALSE(WithDaylightColours(
          LightOf(sky.beam_rgb, glm::dvec3(0.0), sky.diffuse_rgb, elevation_deg)))
          << haze << ", " << elevation_deg;
    }
  }
}

TEST(DaylightColours, RaiseAVanishedChannelOfTheSkyInTheShapeOfTheLargest) {
  const auto overcast = WithDaylightColours(LightOf({0, 0, 0}, {1e-6, 2, 6}, {0, 1, 2}));
  ASSERT_TRUE(overcast);
  EXPECT_EQ(overcast->sky[0].irradiance_rgb, glm::dvec3(1.5, 2, 6));
  EXPECT_EQ(overcast->sky[1].irradiance_rgb, glm::dvec3(0.5, 1, 2));
  EXPECT_EQ(overcast->sun.irradiance_rgb, glm::dvec3(0.0));
}

// As a lawn whose albedo is a guess gives it.
TEST(DaylightColours, AreNotMagenta) {
  const auto light = WithDaylightColours(LightOf({12.9, 5.8, 7.5}, {3.7, 2.4, 5.8}, {0, 0, 0}));
  ASSERT_TRUE(light);
  const auto green = [](const glm::dvec3& rgb) { return rgb.g / std::sqrt(rgb.r * rgb.b); };
  EXPECT_GE(green(light->sun.irradiance_rgb), kLeastGreen - 1e-9);
  EXPECT_GE(green(light->SkyIrradianceRgb()), kLeastGreen - 1e-9);
}

// The light of a courtyard in a camera whose red and blue are 1.7 and 1.4 times its green: where
// surveyed surfaces say so, to 5 %, it is drawn so. Where all that is known is guessed, to 30 %, it
// is drawn as daylight mostly is.
TEST(DaylightColours, OfACameraStandAsFarAsTheyAreMeasured) {
  Lighting measured = LightOf({17.0, 9.0, 10.9}, {0.9, 0.6, 0.7}, {0.5, 0.5, 1.9});
  const auto green_raised_by = [&](double relative_stddev) {
    measured.covariance.assign(81, 0.0);
    for (std::size_t i = 0; i < 9; ++i) {
      const int channel = static_cast<int>(i % 3);
      const double mean = i < 3 ? measured.sun.irradiance_rgb[channel]
                                : measured.sky[i / 3 - 1].irradiance_rgb[channel];
      measured.covariance[i * 10] = std::pow(relative_stddev * mean, 2.0);
    }
    const auto drawn = WithDaylightColours(measured);
    if (drawn) {
      EXPECT_NEAR(
          std::sqrt(drawn->covariance[10]) / drawn->sun.irradiance_rgb.g, relative_stddev, 1e-9);
    }
    return drawn ? drawn->sun.irradiance_rgb.g / measured.sun.irradiance_rgb.g : 1.0;
  };
  EXPECT_EQ(green_raised_by(0.0), 1.0);
  EXPECT_GT(green_raised_by(0.05), 1.0);
  EXPECT_LT(green_raised_by(0.05), 1.07);
  const double usual = kLeastGreen * std::sqrt(17.0 * 10.9) / 9.0;
  EXPECT_NEAR(green_raised_by(0.3), usual, 1e-9);
  measured.sun.irradiance_rgb.g = 3.0;
  EXPECT_NEAR(green_raised_by(0.0), kLeastGreenOfAnyCamera * std::sqrt(17.0 * 10.9) / 3.0, 1e-9);
  measured.sun.irradiance_rgb.g = 9.0;
  measured.covariance.clear();
  EXPECT_NEAR(WithDaylightColours(measured)->sun.irradiance_rgb.g, usual * 9.0, 1e-9);
}

// Takes the one of two lights that has to be raised by less.
TEST(DaylightColours, ShadowsAreNeverRedderThanSunlight) {
  const auto red_sky = WithDaylightColours(LightOf({300, 300, 300}, {80, 40, 30}, {0, 0, 0}));
  ASSERT_TRUE(red_sky);
  EXPECT_EQ(red_sky->sun.irradiance_rgb, glm::dvec3(300.0));
  EXPECT_NEAR(red_sky->SkyIrradianceRgb().r, 80.0, 1e-9);
  EXPECT_NEAR(red_sky->SkyIrradianceRgb().g, 80.0 / 1.2, 1e-6);
  EXPECT_NEAR(red_sky->SkyIrradianceRgb().b, 80.0 / 1.44, 1e-6);
  const auto cyan_sun = WithDaylightColours(LightOf({0, 20, 20}, {100, 100, 100}, {0, 0, 0}));
  ASSERT_TRUE(cyan_sun);
  EXPECT_EQ(cyan_sun->SkyIrradianceRgb(), glm::dvec3(100.0));
  EXPECT_NEAR(cyan_sun->sun.irradiance_rgb.r, 20.0 / 1.2, 1e-6);
}

TEST(DaylightColours, ShadowsAreNoBluerThanTheAirMakesThem) {
  const auto high = WithDaylightColours(LightOf({600, 600, 480}, {1, 10, 160}, {0, 0, 0}, 60.0));
  ASSERT_TRUE(high);
  EXPECT_NEAR(high->SkyIrradianceRgb().g, 160.0 * 600.0 / 480.0 / 2.9, 1e-6);
  EXPECT_NEAR(high->SkyIrradianceRgb().r, 0.25 * 160.0, 1e-6);  // As a sky by itself.
  EXPECT_EQ(high->SkyIrradianceRgb().b, 160.0);
  // A low sun's beam may have lost far more of its blue.
  EXPECT_FALSE(WithDaylightColours(LightOf({600, 200, 40}, {60, 80, 90}, {0, 0, 0}, 3.0)));
  EXPECT_TRUE(WithDaylightColours(LightOf({600, 200, 40}, {60, 80, 90}, {0, 0, 0}, 60.0)));
  // A measured sunrise.
  const glm::dvec3 sun(17.5, 11.8, 3.46);
  const glm::dvec3 sky(0.76, 1.09, 1.59);
  EXPECT_FALSE(WithDaylightColours(LightOf(sun, sky, {0, 0, 0}, 7.9)));
  EXPECT_TRUE(WithDaylightColours(LightOf(sun, sky, {0, 0, 0}, 60.0)));
}

TEST(DaylightColours, AreThereAfterwardsWhateverTheLight) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto any = [&] {
    glm::dvec3 rgb;
    for (int c = 0; c < 3; ++c) {
      rgb[c] = uniform(random) < 0.2 ? 0.0 : std::pow(10.0, 20.0 * uniform(random) - 10.0);
    }
    return rgb;
  };
  int raised = 0;
  int compared = 0;
  for (int i = 0; i < 10000; ++i) {
    const Lighting lighting = LightOf(any(), any(), any(), 180.0 * uniform(random) - 90.0);
    const auto coloured = WithDaylightColours(lighting);
    if (!coloured) continue;
    ++raised;
    const glm::dvec3 sky = coloured->SkyIrradianceRgb();
    const glm::dvec3 sky_was = lighting.SkyIrradianceRgb();
    const glm::dvec3& sun = coloured->sun.irradiance_rgb;
    const glm::dvec3& sun_was = lighting.sun.irradiance_rgb;
    const double largest = std::max({sky_was.x, sky_was.y, sky_was.z});
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(std::isfinite(sky[c]) && std::isfinite(sun[c])) << i;
      ASSERT_GE(sky[c], (1.0 - 1e-9) * std::max(sky_was[c], kLeastSkyChannel * largest)) << i;
      ASSERT_GE(sun[c], sun_was[c]) << i;
    }
    if (!(std::max({sun_was.x, sun_was.y, sun_was.z}) > 0.02 * largest) || largest == 0.0) continue;
    ++compared;
    for (int c = 0; c < 2; ++c) {
      ASSERT_LE(sky[c] / sun[c], 1.201 * sky[c + 1] / sun[c + 1]) << i;
    }
    for (const glm::dvec3& light : {sun, sky}) {
      ASSERT_GE(light.g, 0.999 * kLeastGreen * std::sqrt(light.r * light.b)) << i;
    }
  }
  EXPECT_GT(raised, 5000);
  EXPECT_GT(compared, 3000);
}

}  // namespace
}  // namespace pleinair::daylight_colours_test

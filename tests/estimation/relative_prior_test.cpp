#include "estimation/relative_prior.h"

#include <gtest/gtest.h>

#include "estimation/lighting_fit.h"
#include "tests/estimation/synthetic_scene.h"

namespace pleinair::relative_prior_test {
namespace {

LightingPrior RatioOf(double ratio, int shapes) {
  LightingPrior prior = LightingPrior::Nothing(shapes);
  prior.sun_to_sky_rgb = glm::dvec3(ratio);
  prior.sun_to_sky_weight = 1.0;
  return prior;
}

double Misfit(const LightingPrior& prior, const LightVector& light) {
  return light.dot(prior.information * light) - 2.0 * prior.information_times_mean.dot(light);
}

// At the rough light itself the derivative along a rise of all light is 0: exposure is left alone.
TEST(RelativePrior, SaysNothingOfTheSizeOfTheLight) {
  for (const double sun : {0.0, 100.0, 400.0, 2000.0}) {
    RoughLight rough;
    rough.sun_rgb = glm::dvec3(sun);
    rough.sky_rgb = glm::dvec3(100.0);
    LightingPrior prior = RatioOf(6.0, 2);
    UseRelativeClearSky(rough, prior);
    LightVector light(9);
    light << sun, sun, sun, 60.0, 60.0, 60.0, 40.0, 40.0, 40.0;
    EXPECT_NEAR(light.dot(prior.information * light), 0.0, 1e-9);
    EXPECT_NEAR(Misfit(prior, 1.2 * light), Misfit(prior, light), 1e-9);
    EXPECT_EQ(prior.sun_to_sky_weight, 0.0);
  }
}

// Half the beam and two thirds of its deviation, as the absolute prior at its mean.
TEST(RelativePrior, DrawsTheSunTowardsHalfTheBeam) {
  RoughLight rough;
  rough.sun_rgb = glm::dvec3(300.0);
  rough.sky_rgb = glm::dvec3(100.0);
  LightingPrior prior = RatioOf(6.0, 1);
  UseRelativeClearSky(rough, prior);
  LightVector at_mean(6);
  at_mean << 300.0, 300.0, 300.0, 100.0, 100.0, 100.0;
  LightVector brighter = at_mean;
  brighter.head<3>() *= 1.5;
  LightVector darker = at_mean;
  darker.head<3>() *= 0.5;
  EXPECT_LT(Misfit(prior, at_mean), Misfit(prior, brighter));
  EXPECT_LT(Misfit(prior, at_mean), Misfit(prior, darker));
}

// What made relative light collapse: overcast samples whose level is known to some per cent only.
TEST(RelativePrior, AnOvercastSkyKeepsItsSize) {
  testing::SyntheticScene scene;
  scene.sun = glm::dvec3(0.0);
  scene.albedo_noise = 0.1;
  const auto samples = testing::MakeSamples(scene);
  LightingPrior prior = RatioOf(6.0, 1);
  UseRelativeClearSky(FindRoughLight(samples), prior);
  const LightingFit fit = FitLighting(samples, prior, true);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.irradiance_rgb[3 + c], scene.sky[c], 0.05 * scene.sky[c]);
    EXPECT_LT(fit.irradiance_rgb[c], 0.05 * scene.sky[c]);
  }
}

TEST(RelativePrior, IsDefinedWithoutLight) {
  LightingPrior prior = RatioOf(6.0, 1);
  UseRelativeClearSky({}, prior);
  EXPECT_FALSE(prior.SaysSomething());
}

}  // namespace
}  // namespace pleinair::relative_prior_test

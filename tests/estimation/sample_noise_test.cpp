#include "estimation/sample_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "estimation/lighting_fit.h"
#include "estimation/rough_light.h"
#include "tests/estimation/fit_lighting.h"
#include "tests/estimation/synthetic_scene.h"

namespace pleinair::sample_noise_test {
namespace {

using testing::MakeSamples;
using testing::SyntheticScene;

const SignalNoise& Noise() {
  static const SignalNoise kNoise(ResponseCurve::Srgb());
  return kNoise;
}

// Outliers and noise leave medians alone; lit and shaded samples separate sun and sky.
TEST(RoughLight, IsNearTheLightOfASoundScene) {
  SyntheticScene scene;
  scene.albedo_noise = 0.1;
  scene.outliers = SyntheticScene::Outliers::kRandom;
  scene.outlier_share = 0.2;
  const auto samples = MakeSamples(scene);
  const RoughLight light = FindRoughLight(samples);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(light.sun_rgb[c], scene.sun[c], 0.1 * scene.sun[c]);
    EXPECT_NEAR(light.sky_rgb[c], scene.sky[c], 0.1 * scene.sky[c]);
  }
}

TEST(RoughLight, IsDefinedWhereSamplesAreAlikeOrNone) {
  SyntheticScene scene;
  scene.one_plane = true;
  scene.lit_share = 1.0;
  const RoughLight alike = FindRoughLight(MakeSamples(scene));
  EXPECT_EQ(alike.sun_rgb, alike.sky_rgb);
  // (820 * 0.6 + 95 * 0.8) / (0.6 + 0.8): the samples' own brightness is met.
  EXPECT_NEAR(alike.sun_rgb.x, 405.7, 1.0);
  EXPECT_EQ(FindRoughLight({}).sun_rgb, glm::dvec3(0.0));
}

// Samples of 25 pixels at a signal of about a tenth: shot noise of 1600 electrons, a fifth of it
// in the mean.
TEST(SampleNoise, IsThatOfTheCameraOverTheSamplesPixels) {
  SyntheticScene scene;
  auto samples = MakeSamples(scene);
  for (DiffuseSample& sample : samples) sample.pixels = 25;
  const double exposure = 0.1 / 60.0;
  ApplySignalNoise(Noise(), exposure, samples);
  double mean = 0.0;
  for (const DiffuseSample& sample : samples) {
    for (int c = 0; c < 3; ++c) {
      const double signal = exposure * sample.radiance_rgb[c];
      const double of_mean = std::sqrt(Noise().Variance(c, signal) / 25.0) / exposure;
      // A plane's samples have one relative noise, where each one's own goes with the root of its
      // radiance: within a factor of two of its own, and right on average.
      EXPECT_GT(sample.radiance_stddev_rgb[c], of_mean / 2.0);
      EXPECT_LT(sample.radiance_stddev_rgb[c], of_mean * 2.0);
      mean += sample.radiance_stddev_rgb[c] / of_mean / (3.0 * double(samples.size()));
    }
  }
  EXPECT_NEAR(mean, 1.0, 0.1);
}

TEST(SampleNoise, LeavesOutWhatWhiteOrBlackMayCutOff) {
  SyntheticScene scene;
  const auto samples = MakeSamples(scene);
  double brightest = 0.0;
  for (const DiffuseSample& sample : samples) {
    brightest = std::max(brightest, sample.radiance_rgb.x);
  }
  auto bright = samples;
  ApplySignalNoise(Noise(), 1.0 / brightest, bright);
  int left_out = 0;
  for (const DiffuseSample& sample : bright) {
    left_out += std::isinf(sample.radiance_stddev_rgb.x) ? 1 : 0;
    if (std::isfinite(sample.radiance_stddev_rgb.x)) {
      EXPECT_LT(sample.radiance_rgb.x, 0.9 * brightest);
    }
  }
  EXPECT_GT(left_out, 0);
  EXPECT_LT(left_out, scene.samples / 2);

  auto dark = samples;
  ApplySignalNoise(Noise(), 1e-7, dark);
  for (const DiffuseSample& sample : dark) {
    EXPECT_TRUE(std::isinf(sample.radiance_stddev_rgb.x));
  }
}

TEST(SampleNoise, IsDefinedForNoSamplesAndBlackOnes) {
  std::vector<DiffuseSample> none;
  ApplySignalNoise(Noise(), 1.0, none);
  std::vector<DiffuseSample> black(10);
  ApplySignalNoise(Noise(), 1.0, black);
  for (const DiffuseSample& sample : black) {
    EXPECT_TRUE(std::isinf(sample.radiance_stddev_rgb.y));
  }
}

// Albedos are 10 % off and a part of the samples is clipped: leaving out just those that are, as
// they come, keeps the darker ones of the bright planes.
TEST(SampleNoise, ClippingLeavesNoBias) {
  double sun_by_prediction = 0.0;
  double sun_as_they_come = 0.0;
  constexpr int kScenes = 30;
  for (int run = 0; run < kScenes; ++run) {
    SyntheticScene scene;
    scene.seed = static_cast<std::uint64_t>(run + 1);
    scene.albedo_noise = 0.1;
    scene.sky = glm::dvec3(300.0);
    auto samples = MakeSamples(scene);
    std::vector<double> radiances;
    for (const DiffuseSample& sample : samples) radiances.push_back(sample.radiance_rgb.x);
    std::sort(radiances.begin(), radiances.end());
    const double exposure = 0.95 / radiances[radiances.size() * 8 / 10];
    for (DiffuseSample& sample : samples) {
      if (sample.radiance_rgb.x * exposure < Noise().ClippedFrom(0)) continue;
      sample.radiance_rgb.x = Noise().ClippedFrom(0) / exposure;
      sample.radiance_stddev_rgb.x = std::numeric_limits<double>::infinity();
    }
    const auto sun_of = [](const std::vector<DiffuseSample>& set) {
      return FitLighting(set, LightingPrior::Nothing(1), true).irradiance_rgb[0];
    };
    sun_as_they_come += sun_of(samples) / scene.sun.x / kScenes;
    ApplySignalNoise(Noise(), exposure, samples);
    sun_by_prediction += sun_of(samples) / scene.sun.x / kScenes;
  }

  EXPECT_NEAR(sun_by_prediction, 1.0, 0.015);
  EXPECT_LT(std::abs(sun_by_prediction - 1.0), std::abs(sun_as_they_come - 1.0));
}

// Red is clipped on every sunlit surface but where panes and shadows that the mesh lacks are: their
// red must not determine the sun's, and green and blue still do.
TEST(SampleNoise, WhatIsNotClippedAmongTheClippedIsNotUsed) {
  SyntheticScene scene;
  scene.regions = 1;
  scene.sun.x *= 20.0;  // Far above green and blue.
  scene.sky.x *= 20.0;
  auto samples = MakeSamples(scene);
  double least_lit = std::numeric_limits<double>::max();
  const auto is_lit = [](const DiffuseSample& sample) { return SunShare(sample, 0) > 0.25; };
  for (const DiffuseSample& sample : samples) {
    if (is_lit(sample)) least_lit = std::min(least_lit, sample.radiance_rgb.x);
  }
  int panes = 0;
  int lit = 0;
  for (DiffuseSample& sample : samples) {
    if (!is_lit(sample)) continue;
    if (lit++ % 8 == 0) {
      sample.radiance_rgb *= 0.25;
      ++panes;
      continue;
    }
    sample.radiance_rgb.x = least_lit;
    sample.radiance_stddev_rgb.x = std::numeric_limits<double>::infinity();
  }
  ASSERT_GT(panes, 20);

  ApplySignalNoise(Noise(), 1.0 / least_lit, samples);
  for (const DiffuseSample& sample : samples) {
    EXPECT_EQ(std::isinf(sample.radiance_stddev_rgb.x), is_lit(sample));
    EXPECT_TRUE(std::isfinite(sample.radiance_stddev_rgb.z));
  }
  const LightingFit fit = FitLighting(samples, LightingPrior::Nothing(1), true);
  for (int c = 1; c < 3; ++c) {
    EXPECT_NEAR(fit.irradiance_rgb[c], scene.sun[c], 0.02 * scene.sun[c]) << c;
    EXPECT_NEAR(fit.irradiance_rgb[3 + c], scene.sky[c], 0.02 * scene.sky[c]) << c;
  }
}

// The relative noise of dark samples must not count as light: an overcast scene of uneven
// albedos, at a signal of some per cent.
TEST(SampleNoise, NoiseOfDarkFramesLeavesNoBias) {
  double sky = 0.0;
  constexpr int kScenes = 30;
  for (int run = 0; run < kScenes; ++run) {
    SyntheticScene scene;
    scene.seed = static_cast<std::uint64_t>(run + 1);
    scene.albedo_noise = 0.1;
    scene.sun = glm::dvec3(0.0);
    auto samples = MakeSamples(scene);
    for (DiffuseSample& sample : samples) sample.pixels = 9;
    const double exposure = 0.05 / 10.0;
    std::mt19937_64 random(scene.seed);
    std::normal_distribution<double> gauss;
    for (DiffuseSample& sample : samples) {
      for (int c = 0; c < 3; ++c) {
        const double variance = Noise().Variance(c, exposure * sample.radiance_rgb[c]) / 9.0;
        sample.radiance_rgb[c] += std::sqrt(variance) / exposure * gauss(random);
      }
    }
    ApplySignalNoise(Noise(), exposure, samples);
    const LightingFit fit = FitLighting(samples, LightingPrior::Nothing(1), true);
    sky += fit.irradiance_rgb[3] / scene.sky.x / kScenes;
  }

  // Six planes with albedo errors of each sample alone: 0.1 / sqrt(500 * 30), and as much again
  // for the sun that may not be below 0.
  EXPECT_NEAR(sky, 1.0, 0.01);
}

}  // namespace
}  // namespace pleinair::sample_noise_test

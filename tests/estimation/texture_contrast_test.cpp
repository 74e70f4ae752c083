#include "estimation/texture_contrast.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair::texture_contrast_test {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

double Of(const std::array<double, kSkyStates>& log, SkyState state) {
  return log[static_cast<std::size_t>(state)];
}

// Log-normal grain of this deviation, from pixel to pixel.
Frame Grain(double stddev) {
  Frame frame;
  frame.radiance = RgbImage(kWidth, kHeight);
  frame.unusable = Gray8Image(kWidth, kHeight);
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, stddev);
  for (glm::vec3& pixel : frame.radiance.pixels) {
    pixel = glm::vec3(static_cast<float>(std::exp(normal(random))));
  }
  return frame;
}

std::vector<DiffuseSample> SamplesOnARaster() {
  std::vector<DiffuseSample> samples;
  for (int y = 10; y < kHeight - 10; y += 8) {
    for (int x = 10; x < kWidth - 10; x += 8) {
      DiffuseSample sample;
      sample.pixel = {x, y};
      samples.push_back(sample);
    }
  }
  return samples;
}

TEST(TextureContrast, IsTheDeviationOfTheLogarithm) {
  // Each square has 81 values of its own; their median is within a few per cent.
  for (const double stddev : {0.1, 0.4, 0.8}) {
    const auto contrast = FineContrast(Grain(stddev), SamplesOnARaster());
    ASSERT_TRUE(contrast.has_value());
    EXPECT_NEAR(*contrast, stddev, 0.08 * stddev);
  }
}

TEST(TextureContrast, DoesNotDependOnTheExposure) {
  Frame frame = Grain(0.4);
  const auto before = FineContrast(frame, SamplesOnARaster());
  for (glm::vec3& pixel : frame.radiance.pixels) pixel *= 0.125f;
  EXPECT_DOUBLE_EQ(*FineContrast(frame, SamplesOnARaster()), *before);
}

TEST(TextureContrast, SaysNothingOfClippedOrFewSquares) {
  Frame frame = Grain(0.4);
  std::vector<DiffuseSample> few = SamplesOnARaster();
  few.resize(40);
  EXPECT_FALSE(FineContrast(frame, few).has_value());
  for (const std::uint8_t unsound : {kUnusable, kNearBlack, kClipped[1]}) {
    for (std::uint8_t& pixel : frame.unusable.pixels) pixel = unsound;
    EXPECT_FALSE(FineContrast(frame, SamplesOnARaster()).has_value());
  }
  // Green alone is read.
  for (std::uint8_t& pixel : frame.unusable.pixels) pixel = kClipped[0];
  EXPECT_TRUE(FineContrast(frame, SamplesOnARaster()).has_value());
  frame = Grain(0.4);
  for (glm::vec3& pixel : frame.radiance.pixels) pixel.g = std::nanf("");
  EXPECT_FALSE(FineContrast(frame, SamplesOnARaster()).has_value());
}

TEST(TextureContrast, DeepShadowsAreTheSuns) {
  const auto log = LogLikelihood(TextureContrast{0.8, 0.8});
  EXPECT_GT(Of(log, SkyState::kClear), Of(log, SkyState::kVeiledSun));
  EXPECT_GT(Of(log, SkyState::kVeiledSun), Of(log, SkyState::kOvercast));
}

TEST(TextureContrast, WhatIsNoLongerDeepHasLostTheSun) {
  const auto log = LogLikelihood(TextureContrast{0.25, 0.8});
  EXPECT_LT(Of(log, SkyState::kClear), Of(log, SkyState::kCoveredSun));
}

TEST(TextureContrast, SmoothSurfacesSayNothing) {
  for (const double most : {0.05, 0.2, 0.34}) {
    for (const double log : LogLikelihood(TextureContrast{0.05, most})) EXPECT_EQ(log, 0.0);
  }
  for (const double log : LogLikelihood(TextureContrast{0.0, 0.0})) EXPECT_EQ(log, 0.0);
}

TEST(TextureContrast, TheMostIsOneCamerasOwn) {
  TextureWatch watch;
  Camera camera;
  EXPECT_NEAR(watch.Look(Grain(0.8), camera, SamplesOnARaster())->most, 0.8, 0.08);
  const auto later = watch.Look(Grain(0.2), camera, SamplesOnARaster());
  EXPECT_NEAR(later->most, 0.8, 0.08);
  EXPECT_NEAR(later->now, 0.2, 0.02);
  camera.intrinsics.fx_px += 1.0;
  EXPECT_NEAR(watch.Look(Grain(0.2), camera, SamplesOnARaster())->most, 0.2, 0.02);
}

}  // namespace
}  // namespace pleinair::texture_contrast_test

// Real pixels in new light where the model of the old one is wrong, down to no light at all.
#include "render/relit_pixel.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "render/real_sun.h"

namespace pleinair::test::relit_pixel_test {
namespace {

constexpr float kInvPi = std::numbers::inv_pi_v<float>;

PixelInNewLight GreyPixel(const glm::vec3& camera,
                          const glm::vec3& before,
                          const glm::vec3& after) {
  return {.camera = camera,
          .albedo = glm::vec3(0.2f),
          .albedo_measured = true,
          .irradiance_before = before,
          .irradiance_after = after};
}

// A pixel's own albedo within 1.3 times the model's, in a channel by 1.1 times more.
TEST(RelitPixel, IsScaledByTheModelsRatioWhereTheModelIsRight) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (int i = 0; i < 1000; ++i) {
    PixelInNewLight pixel;
    pixel.albedo_measured = i % 2 == 0;
    const float brightness = std::exp(0.5f * uniform(random) - 0.25f);
    for (int c = 0; c < 3; ++c) {
      pixel.albedo[c] = 0.05f + 0.4f * uniform(random);
      pixel.irradiance_before[c] = 1.0f + 9.0f * uniform(random);
      pixel.irradiance_after[c] = pixel.irradiance_before[c] * 2.0f * uniform(random);
      const float hue = std::exp(0.2f * uniform(random) - 0.1f);
      pixel.camera[c] = brightness * hue * kInvPi * pixel.albedo[c] * pixel.irradiance_before[c];
    }
    const RelitRadiance relit = Relit(pixel);
    for (int c = 0; c < 3; ++c) {
      const float expected =
          pixel.camera[c] * pixel.irradiance_after[c] / pixel.irradiance_before[c];
      // And what a half float would round off is no change.
      EXPECT_NEAR(relit.radiance[c], expected, 1e-5f * expected + pixel.camera[c] / 2048.0f) << i;
    }
  }
}

// For any values of camera and model: zero, tiny and huge light are all covered.
TEST(RelitPixel, BrightensByNoMoreThanTheRadianceOfWhatShinesOnIt) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const auto any_light = [&] {
    return uniform(random) < 0.2f ? 0.0f : std::pow(10.0f, 40.0f * uniform(random) - 30.0f);
  };
  int without_light = 0;
  int brighter = 0;
  int darker = 0;
  for (int i = 0; i < 20000; ++i) {
    PixelInNewLight pixel;
    pixel.albedo_measured = uniform(random) < 0.5f;
    pixel.clipped = uniform(random) < 0.2f;
    for (int c = 0; c < 3; ++c) {
      pixel.camera[c] = any_light();
      pixel.albedo[c] = uniform(random) < 0.2f ? 0.0f : uniform(random);
      pixel.irradiance_before[c] = any_light();
      pixel.irradiance_after[c] = any_light();
    }
    const RelitRadiance relit = Relit(pixel);
    for (int c = 0; c < 3; ++c) {
      const float added = pixel.irradiance_after[c] - pixel.irradiance_before[c];
      ASSERT_TRUE(std::isfinite(relit.radiance[c])) << i;
      ASSERT_GE(relit.radiance[c], 0.0f) << i;
      ASSERT_LE(relit.radiance[c], 1.00001f * (pixel.camera[c] + kInvPi * std::max(added, 0.0f)))
          << i;
      without_light += pixel.irradiance_before[c] == 0.0f ? 1 : 0;
      brighter += relit.radiance[c] > pixel.camera[c] ? 1 : 0;
      darker += relit.radiance[c] < pixel.camera[c] ? 1 : 0;
    }
  }
  EXPECT_GT(without_light, 10000);
  EXPECT_GT(brighter, 5000);
  EXPECT_GT(darker, 5000);
}

// A grey pixel beside a white wall, under a sky that lost its blue.
TEST(RelitPixel, DoesNotTurnColouredWithTheLightsWeakestChannel) {
  const glm::vec3 camera(0.2f * kInvPi);
  for (const float blue : {0.1f, 1e-3f, 1e-9f, 0.0f}) {
    const glm::vec3 before(1.0f, 1.0f, blue);
    const glm::vec3 gained = Relit(GreyPixel(camera, before, before + 0.5f)).radiance - camera;
    EXPECT_NEAR(gained.r, 0.5f * camera.r, 1e-6f) << blue;
    EXPECT_LE(gained.b / gained.r, 1.00001f * std::exp(kMostAlbedoSigmas * kLogSigmaMeasured))
        << blue;
  }
}

// What is far brighter than the model has it may shine by itself, or be in light that the model
// lacks: it gains what a surface of the model's albedo would, within that one's error.
TEST(RelitPixel, GainsByTheModelsAlbedoWhereItIsFarBrighter) {
  const glm::vec3 lamp(5.0f, 0.0f, 50.0f);
  const glm::vec3 relit = Relit(GreyPixel(lamp, glm::vec3(1.0f), glm::vec3(1.5f))).radiance;
  const float most = std::exp(kMostAlbedoSigmas * kLogSigmaMeasured) * 0.2f * kInvPi * 0.5f;
  EXPECT_NEAR(relit.r - lamp.r, most, 1e-6f);
  EXPECT_EQ(relit.g, 0.0f);
  EXPECT_NEAR(relit.b - lamp.b, most, 1e-5f);
}

// The model may be far brighter than the camera could show.
TEST(RelitPixel, AClippedPixelNeverBrightensInTheShade) {
  PixelInNewLight pixel = GreyPixel(glm::vec3(1.0f), glm::vec3(100.0f), glm::vec3(30.0f));
  pixel.clipped = true;
  EXPECT_EQ(Relit(pixel).radiance, glm::vec3(1.0f));
  pixel.irradiance_after = glm::vec3(3.0f);
  EXPECT_NEAR(Relit(pixel).radiance.g, 0.2f * kInvPi * 3.0f, 1e-6f);
  pixel.clipped = false;
  EXPECT_NEAR(Relit(pixel).radiance.g, 0.03f, 1e-6f);
}

TEST(RelitPixel, BlackStaysBlack) {
  const RelitRadiance relit =
      Relit(GreyPixel(glm::vec3(0.0f), glm::vec3(0.0f, 1.0f, 2.0f), glm::vec3(3.0f)));
  EXPECT_EQ(relit.radiance, glm::vec3(0.0f));
}

}  // namespace
}  // namespace pleinair::test::relit_pixel_test

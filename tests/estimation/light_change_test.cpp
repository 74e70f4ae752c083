#include "estimation/light_change.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/estimation/synthetic_scene.h"

namespace pleinair::light_change_test {
namespace {

using testing::MakeSamples;
using testing::SyntheticScene;

// Guessed albedos: of the planes by 20 %, of single places by 10 %.
SyntheticScene WithGuessedAlbedos(std::uint64_t seed = 1) {
  SyntheticScene scene;
  scene.seed = seed;
  scene.region_noise = 0.2;
  scene.albedo_noise = 0.1;
  return scene;
}

// The same seed gives the same places and errors under any light; each picture has noise of 1 %.
std::vector<DiffuseSample> SamplesUnder(SyntheticScene scene,
                                        double sun,
                                        double sky,
                                        std::uint64_t picture = 1) {
  scene.sun *= sun;
  scene.sky *= sky;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  std::mt19937_64 random(picture);
  std::normal_distribution<double> gauss;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].place_world_m = {static_cast<float>(i), 0.5f, 1.0f};
    for (int c = 0; c < 3; ++c) samples[i].radiance_rgb[c] *= 1.0 + 0.01 * gauss(random);
  }
  return samples;
}

// An estimate of `scene` that is wrong as albedos make it.
Lighting EstimateOf(const SyntheticScene& scene, double sun = 1.0, double sky = 1.0) {
  Lighting lighting;
  lighting.sun.direction_enu = {0.0, 0.6, 0.8};
  lighting.sun.irradiance_rgb = 1.05 * sun * scene.sun;
  lighting.sky = {{"uniform", 0.85 * sky * scene.sky}};
  return lighting;
}

// From the light itself to `sun` and `sky` times it, as seen in the samples `after`.
std::optional<LightChange> ChangeTo(const SyntheticScene& scene,
                                    std::span<const DiffuseSample> after,
                                    double sun_before = 1.0) {
  LightChangeWatch watch;
  EXPECT_FALSE(watch.Compare(SamplesUnder(scene, sun_before, 1.0), EstimateOf(scene, sun_before))
                   .has_value());
  return watch.Compare(after, EstimateOf(scene));
}

TEST(LightChange, AlbedosThatAreWrongAreWrongInBothFrames) {
  struct Case {
    double sun;
    double sky;
  };
  for (const Case& light : {Case{1.0, 1.0}, Case{0.6, 1.1}, Case{0.05, 1.5}, Case{1.0, 0.8}}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const SyntheticScene scene = WithGuessedAlbedos(seed);
      const auto change = ChangeTo(scene, SamplesUnder(scene, light.sun, light.sky, 2));
      ASSERT_TRUE(change.has_value());
      for (int c = 0; c < 3; ++c) {
        // Of a large change a part is wrong: the last estimate gives each place's error to sun and
        // sky in its own, wrong parts.
        EXPECT_NEAR(change->sun_after_rgb[c] / change->sun_before_rgb[c],
                    light.sun,
                    0.01 + 0.05 * std::abs(light.sun - 1.0));
        EXPECT_NEAR(change->sky_after_rgb[c] / change->sky_before_rgb[c],
                    light.sky,
                    0.02 + 0.25 * std::abs(light.sky - 1.0));
        EXPECT_LT(change->sun_stddev_rgb[c] / change->sun_before_rgb[c],
                  0.02 + 0.11 * std::abs(light.sun - 1.0));
      }
    }
  }
}

TEST(LightChange, DeviationsHold) {
  for (const double cloud : {1.0, 0.7}) {
    int within = 0;
    int all = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const SyntheticScene scene = WithGuessedAlbedos(seed);
      const auto change = ChangeTo(scene, SamplesUnder(scene, cloud, 2.0 - cloud, seed + 100));
      ASSERT_TRUE(change.has_value());
      for (int c = 0; c < 3; ++c, all += 2) {
        const double sun = cloud * change->sun_before_rgb[c];
        const double sky = (2.0 - cloud) * change->sky_before_rgb[c];
        const double sun_off = std::abs(change->sun_after_rgb[c] - sun);
        const double sky_off = std::abs(change->sky_after_rgb[c] - sky);
        within += sun_off <= 2.0 * change->sun_stddev_rgb[c] ? 1 : 0;
        within += sky_off <= 2.0 * change->sky_stddev_rgb[c] ? 1 : 0;
      }
    }
    EXPECT_GE(within, cloud < 1.0 ? all * 9 / 10 : all * 95 / 100) << cloud;
  }
}

TEST(LightChange, ASunThatComesOutIsSeen) {
  const SyntheticScene scene = WithGuessedAlbedos();
  const auto change = ChangeTo(scene, SamplesUnder(scene, 1.0, 1.0, 2), 0.0);
  ASSERT_TRUE(change.has_value());
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(change->sun_before_rgb[c], 0.0);
    // To what the last estimate's sky is wrong by.
    EXPECT_NEAR(change->sun_after_rgb[c], 0.85 * scene.sun[c], 0.1 * scene.sun[c]);
  }
}

// A tree that was not there shades a third of the places.
TEST(LightChange, AThirdOfThePlacesMayChangeByThemselves) {
  const SyntheticScene scene = WithGuessedAlbedos();
  std::vector<DiffuseSample> after = SamplesUnder(scene, 1.0, 1.0, 2);
  for (std::size_t i = 0; i < after.size() / 3; ++i) after[i].radiance_rgb *= 0.2;
  const auto change = ChangeTo(scene, after);
  ASSERT_TRUE(change.has_value());
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(change->sun_after_rgb[c] / change->sun_before_rgb[c], 1.0, 0.02);
    EXPECT_NEAR(change->sky_after_rgb[c] / change->sky_before_rgb[c], 1.0, 0.04);
  }
}

TEST(LightChange, PlacesInTheSunThatHaveNotChangedAreNoEvidenceOfAnotherSky) {
  SyntheticScene scene = WithGuessedAlbedos();
  scene.lit_share = 1.0;
  scene.one_plane = true;
  const auto change = ChangeTo(scene, SamplesUnder(scene, 1.0, 1.0, 2));
  ASSERT_TRUE(change.has_value());
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(change->sky_after_rgb[c] / change->sky_before_rgb[c], 1.0, 0.01);
    EXPECT_LT(change->sky_stddev_rgb[c], 0.02 * change->sky_before_rgb[c]);
  }
}

// As a camera that moves has them: half of the places leave, others come, and the order is another.
TEST(LightChange, OrderAndNewPlacesDoNotMatter) {
  const SyntheticScene scene = WithGuessedAlbedos();
  std::vector<DiffuseSample> after = SamplesUnder(scene, 0.6, 1.1, 2);
  for (std::size_t i = 0; i < after.size(); i += 2) after[i].place_world_m.z += 1.0f;
  std::shuffle(after.begin(), after.end(), std::mt19937_64(5));
  const auto change = ChangeTo(scene, after);
  ASSERT_TRUE(change.has_value());
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(change->sun_after_rgb[c] / change->sun_before_rgb[c], 0.6, 0.03);
    EXPECT_NEAR(change->sky_after_rgb[c] / change->sky_before_rgb[c], 1.1, 0.05);
  }
}

TEST(LightChangeHardCases, OtherPlacesAreNoEvidence) {
  const SyntheticScene scene = WithGuessedAlbedos();
  std::vector<DiffuseSample> after = SamplesUnder(scene, 1.0, 1.0, 2);
  for (DiffuseSample& sample : after) sample.place_world_m.z += 1.0f;
  EXPECT_FALSE(ChangeTo(scene, after).has_value());
  // A few that are still in view are not enough.
  for (std::size_t i = 0; i < 20; ++i) after[i].place_world_m.z = 1.0f;
  EXPECT_FALSE(ChangeTo(scene, after).has_value());
  EXPECT_FALSE(ChangeTo(scene, {}).has_value());
}

// A wrong pose: every place shows another surface.
TEST(LightChangeHardCases, PlacesThatShowOtherSurfacesAreNoEvidence) {
  const SyntheticScene scene = WithGuessedAlbedos();
  std::vector<DiffuseSample> after = SamplesUnder(scene, 1.0, 1.0, 2);
  std::mt19937_64 random(3);
  for (DiffuseSample& sample : after) {
    sample.radiance_rgb *= std::exp(std::normal_distribution<double>(0.0, 0.8)(random));
  }
  EXPECT_FALSE(ChangeTo(scene, after).has_value());
}

// Most places are clipped, black, broken or were rejected, and would all show less light.
TEST(LightChangeHardCases, ClippedBlackAndBrokenPlacesAreLeftOut) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const SyntheticScene scene = WithGuessedAlbedos();
  std::vector<DiffuseSample> after = SamplesUnder(scene, 1.0, 1.0, 2);
  for (std::size_t i = 0; i < after.size(); ++i) {
    DiffuseSample& sample = after[i];
    if (i % 10 >= 6) continue;
    sample.radiance_rgb *= 0.3;
    if (i % 10 <= 1) sample.radiance_stddev_rgb.g = kInfinity;
    if (i % 10 == 2) sample.radiance_rgb.r = 0.0;
    if (i % 10 == 3) sample.radiance_rgb.b = std::numeric_limits<double>::quiet_NaN();
    if (i % 10 >= 4) sample.is_rejected = true;
  }
  const auto change = ChangeTo(scene, after);
  ASSERT_TRUE(change.has_value());
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(change->sun_after_rgb[c] / change->sun_before_rgb[c], 1.0, 0.02);
  }
}

TEST(LightChangeHardCases, NightIsNoLightToChange) {
  SyntheticScene scene = WithGuessedAlbedos();
  LightChangeWatch watch;
  Lighting night = EstimateOf(scene, 0.0, 0.0);
  for (int frame = 0; frame < 3; ++frame) {
    EXPECT_FALSE(watch.Compare(SamplesUnder(scene, 0.0, 0.0), night).has_value());
  }
}

}  // namespace
}  // namespace pleinair::light_change_test

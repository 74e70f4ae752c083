#include "estimation/shadow_cues.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "estimation/lighting_fit.h"
#include "estimation/lighting_prior.h"
#include "tests/estimation/fit_lighting.h"
#include "tests/estimation/synthetic_scene.h"

namespace pleinair::shadow_cues_test {
namespace {

using testing::MakeSamples;
using testing::SyntheticClearSky;
using testing::SyntheticScene;

// One sunlit plane, as a webcam's only ground plane is.
SyntheticScene SunlitGround() {
  SyntheticScene scene;
  scene.one_plane = true;
  scene.lit_share = 1.0;
  scene.albedo_noise = 0.05;
  return scene;
}

// Every third sample in the shadow of a tree that the mesh lacks.
std::vector<DiffuseSample> WithATree(const SyntheticScene& scene) {
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  for (std::size_t i = 0; i < samples.size(); i += 3) {
    samples[i].radiance_rgb -= scene.sun * samples[i].sun_transport_rgb;
  }
  return samples;
}

TEST(ShadowCues, AnUnmodelledShadowIsEvidenceOfSunOverSky) {
  const SyntheticScene scene = SunlitGround();
  std::vector<DiffuseSample> samples = WithATree(scene);
  const ShadowCues cues = FindShadows(samples);
  EXPECT_NEAR(cues.shaded, 167, 5);
  EXPECT_FALSE(cues.flat);
  // Without units a plane in the sun alone says nothing of sun over sky.
  ClearSkyExpectation clear_sky = SyntheticClearSky();
  clear_sky.absolute = false;
  const LightingFit fit = FitLighting(samples, MakeClimatePrior(clear_sky, 1), true);
  for (int c = 0; c < 3; ++c) {
    const double ratio = fit.irradiance_rgb[c] / fit.irradiance_rgb[3 + c];
    // The albedos' 5 % over 167 samples, and the part of the sun's light that shade keeps.
    EXPECT_NEAR(ratio / (scene.sun[c] / scene.sky[c]), 1.0, 0.35);
  }
}

TEST(ShadowCues, AnEdgeOfAlbedoIsNoShadow) {
  const SyntheticScene scene = SunlitGround();
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  for (std::size_t i = 0; i < samples.size(); i += 3) samples[i].radiance_rgb *= 0.3;
  EXPECT_EQ(FindShadows(samples).shaded, 0);
}

TEST(ShadowCues, AnEvenPlaneSpeaksAgainstTheSun) {
  std::vector<DiffuseSample> samples = MakeSamples(SunlitGround());
  const ShadowCues cues = FindShadows(samples);
  EXPECT_TRUE(cues.flat);
  const auto log = LogLikelihood(cues);
  EXPECT_LT(log[static_cast<std::size_t>(SkyState::kClear)],
            log[static_cast<std::size_t>(SkyState::kOvercast)]);
}

// Whose shadows decide.
TEST(ShadowCues, SaysNothingWhereTheMeshCastsShadows) {
  const SyntheticScene scene;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  std::sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) {
    return a.plane < b.plane;
  });
  const std::vector<DiffuseSample> before = samples;
  const ShadowCues cues = FindShadows(samples);
  EXPECT_EQ(cues.shaded, 0);
  EXPECT_FALSE(cues.flat);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].sun_transport_rgb, before[i].sun_transport_rgb);
  }
}

}  // namespace
}  // namespace pleinair::shadow_cues_test

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "estimation/outdoor_estimator.h"
#include "tests/estimation/synthetic_scene.h"

namespace pleinair::outdoor_estimator_hard_cases_test {
namespace {

using testing::MakeSamples;
using testing::SyntheticClearSky;
using testing::SyntheticScene;

OutdoorConditions ConditionsOf(const std::vector<std::string>& shapes) {
  OutdoorConditions conditions;
  conditions.time = UtcTime{std::chrono::hours(12)};
  conditions.sun.direction_enu = {0.8, 0.0, 0.6};
  conditions.clear_sky = SyntheticClearSky();
  conditions.sky_shape_names = shapes;
  return conditions;
}

// Surfaces that are all in the sun, whose model takes all of their light for the sun's: a sun has a
// sky all the same, in every channel.
TEST(OutdoorEstimatorHardCases, ASunHasASkyWhateverAWrongModelSays) {
  const std::vector<std::string> shapes{"uniform"};
  SyntheticScene scene;
  scene.lit_share = 1.0;
  scene.albedo_noise = 0.02;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  for (DiffuseSample& sample : samples) {
    sample.radiance_rgb = 1.1 * scene.sun * sample.sun_transport_rgb;
  }
  const ClearSkyExpectation clear_sky = SyntheticClearSky();
  const auto estimate =
      OutdoorEstimator(LightingFitOptions{}).Estimate(samples, ConditionsOf(shapes));
  ASSERT_TRUE(estimate.has_value());
  const Lighting& light = estimate->lighting;
  for (int c = 0; c < 3; ++c) {
    const double clear =
        light.sun.irradiance_rgb[c] * clear_sky.diffuse_rgb[c] / clear_sky.beam_rgb[c];
    EXPECT_GT(light.SkyIrradianceRgb()[c], 0.3 * clear);
  }
}

// Nor does a dull sky over surfaces that are all in shade say that the sun, which they do not show,
// is as dull.
TEST(OutdoorEstimatorHardCases, ASkyThatIsSeenSaysNothingOfASunThatIsNot) {
  const std::vector<std::string> shapes{"uniform"};
  const ClearSkyExpectation clear_sky = SyntheticClearSky();
  SyntheticScene scene;
  scene.lit_share = 0.0;
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  std::mt19937_64 random(1);
  std::normal_distribution<double> texture(1.0, 0.1);
  for (DiffuseSample& sample : samples) {
    sample.sun_transport_rgb *= 0.01;
    sample.radiance_rgb =
        texture(random) * (0.25 * clear_sky.diffuse_rgb * sample.sky_transport_rgb[0] +
                           clear_sky.beam_rgb * sample.sun_transport_rgb);
  }
  OutdoorConditions conditions = ConditionsOf(shapes);
  const auto estimate = OutdoorEstimator(LightingFitOptions{}).Estimate(samples, conditions);
  ASSERT_TRUE(estimate.has_value());
  const Lighting& light = estimate->lighting;
  for (int c = 0; c < 3; ++c) {
    const double stddev = std::sqrt(light.covariance[static_cast<std::size_t>(7 * c)]);
    EXPECT_NEAR(light.sun.irradiance_rgb[c], clear_sky.beam_rgb[c], stddev);
    // That of any sun between none and a clear sky's being as likely: the climate knows more.
    EXPECT_LT(stddev, clear_sky.beam_rgb[c] / std::sqrt(12.0));
    EXPECT_NEAR(light.SkyIrradianceRgb()[c],
                0.25 * clear_sky.diffuse_rgb[c],
                0.05 * clear_sky.diffuse_rgb[c]);
  }
}

// A picture that is seen again says nothing new: a thousand of an ambiguous one leave the weathers
// as probable as the first did, and the light where it was.
TEST(OutdoorEstimatorHardCases, TheSamePictureAgainIsNoNewEvidence) {
  const std::vector<std::string> shapes{"uniform"};
  SyntheticScene scene;
  scene.one_plane = true;
  scene.lit_share = 1.0;
  scene.sun = glm::dvec3(0.0);
  scene.sky = {200.0, 205.0, 210.0};
  std::vector<DiffuseSample> samples = MakeSamples(scene);
  OutdoorEstimator estimator{LightingFitOptions{}};
  OutdoorConditions conditions = ConditionsOf(shapes);
  const auto first = estimator.Estimate(samples, conditions);
  ASSERT_TRUE(first && first->weather_shares);
  for (int frame = 1; frame <= 1000; ++frame) {
    conditions.time += std::chrono::milliseconds(33);
    const auto again = estimator.Estimate(samples, conditions);
    ASSERT_TRUE(again && again->weather_shares);
    for (std::size_t w = 0; w < first->weather_shares->size(); ++w) {
      ASSERT_NEAR((*again->weather_shares)[w], (*first->weather_shares)[w], 0.25) << frame;
    }
    ASSERT_NEAR(again->lighting.SkyIrradianceRgb().y,
                first->lighting.SkyIrradianceRgb().y,
                0.1 * first->lighting.SkyIrradianceRgb().y)
        << frame;
  }
}

}  // namespace
}  // namespace pleinair::outdoor_estimator_hard_cases_test

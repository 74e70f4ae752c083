#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "estimation/lighting_prior.h"
#include "estimation/outdoor_lighting_source.h"
#include "tests/estimation/synthetic_view.h"

namespace pleinair {
namespace {

using testing::MakeFrame;
using testing::MakeView;
using testing::Observe;
using testing::SyntheticPicture;

void ExpectSane(const LightingEstimate& estimate) {
  const Lighting& lighting = estimate.lighting;
  for (int c = 0; c < 3; ++c) {
    EXPECT_GE(lighting.sun.irradiance_rgb[c], 0.0);
    EXPECT_TRUE(std::isfinite(lighting.sun.irradiance_rgb[c]));
    EXPECT_GE(lighting.SkyIrradianceRgb()[c], 0.0);
    EXPECT_TRUE(std::isfinite(lighting.SkyIrradianceRgb()[c]));
  }
  for (const double value : lighting.covariance) EXPECT_TRUE(std::isfinite(value));
}

TEST(OutdoorLightingSourceHardCases, NotFinitePixelsAreIgnored) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  std::mt19937_64 random(2);
  for (int i = 0; i < 300; ++i) {
    glm::vec3& pixel = frame.radiance.pixels[random() % frame.radiance.pixels.size()];
    pixel = glm::vec3(i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN()
                                 : std::numeric_limits<float>::infinity());
  }
  const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value());
  ExpectSane(*estimate);
  EXPECT_NEAR(estimate->lighting.sun.irradiance_rgb.x, picture.sun.x, 0.01 * picture.sun.x);
}

TEST(OutdoorLightingSourceHardCases, WithoutAUsablePixelThePriorAnswersOrTheReasonIsTold) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  std::fill(frame.unusable.pixels.begin(), frame.unusable.pixels.end(), 1);
  const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value());
  ExpectSane(*estimate);
  EXPECT_EQ(estimate->samples_used, 0);
  EXPECT_FALSE(estimate->sun_observable);
  EXPECT_NEAR(estimate->lighting.sun.irradiance_rgb.x, kSunPriorMean * 850.0, 10.0);

  LightingObservation unknown = Observe(frame, view);
  unknown.clear_sky = {};
  const auto failure = MakeOutdoorLightingSource({})->Estimate(unknown);
  ASSERT_FALSE(failure.has_value());
  EXPECT_NE(failure.error().reason.find("no usable sample"), std::string::npos);
}

TEST(OutdoorLightingSourceHardCases, AllInShadowAndAllInSunAreSaidOrSolved) {
  for (const double share : {0.0, 1.0}) {
    SyntheticPicture picture;
    picture.shadow_share = share;
    picture.noise = 0.05;
    SurfaceView view = MakeView(picture);
    const Frame frame = MakeFrame(picture, view);
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
    ASSERT_TRUE(estimate.has_value());
    ExpectSane(*estimate);
    for (int c = 0; c < 3; ++c) {
      const double sigma =
          std::sqrt(estimate->lighting.covariance[static_cast<std::size_t>(7 * c)]);
      EXPECT_LE(std::abs(estimate->lighting.sun.irradiance_rgb[c] - picture.sun[c]), 3.0 * sigma);
      EXPECT_LE(sigma, 0.4 * 850.0);
    }
    if (share == 1.0) {
      EXPECT_FALSE(estimate->sun_observable);
    }
  }
}

TEST(OutdoorLightingSourceHardCases, BelowTheHorizonThereIsNoSun) {
  SyntheticPicture picture;
  picture.sun = glm::dvec3(0.0);
  SurfaceView view = MakeView(picture);
  view.sun_direction_enu = glm::normalize(glm::dvec3(-1.0, -1.0, -0.02));
  const Frame frame = MakeFrame(picture, view);
  const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value());
  ExpectSane(*estimate);
  EXPECT_EQ(estimate->lighting.sun.irradiance_rgb, glm::dvec3(0.0));
  EXPECT_FALSE(estimate->sun_observable);
}

TEST(OutdoorLightingSourceHardCases, TinyPicturesGiveADefinedAnswer) {
  for (const int size : {1, 2, 11, 13}) {
    SyntheticPicture picture;
    picture.width = picture.height = size;
    const SurfaceView view = MakeView(picture);
    const Frame frame = MakeFrame(picture, view);
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
    ASSERT_TRUE(estimate.has_value());
    ExpectSane(*estimate);
  }
}

// Powers of two are exact in float, so nothing but the fit's own scale could change.
TEST(OutdoorLightingSourceHardCases, AnyUnitOfRadianceWillDo) {
  SyntheticPicture picture;
  picture.noise = 0.05;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  const auto reference = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view)).value();
  for (const int exponent : {-27, -10, 10, 27}) {
    const double scale = std::ldexp(1.0, exponent);
    Frame scaled = frame;
    for (glm::vec3& pixel : scaled.radiance.pixels) pixel *= static_cast<float>(scale);
    LightingObservation observation = Observe(scaled, view);
    observation.clear_sky.beam_rgb *= scale;
    observation.clear_sky.diffuse_rgb *= scale;
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(observation).value();
    EXPECT_NEAR(estimate.lighting.sun.irradiance_rgb.x / scale,
                reference.lighting.sun.irradiance_rgb.x,
                1e-9 * reference.lighting.sun.irradiance_rgb.x);
    EXPECT_EQ(estimate.sun_observable, reference.sun_observable);
  }
}

TEST(OutdoorLightingSourceHardCases, ThreadsDoNotChangeABit) {
  SyntheticPicture picture;
  picture.noise = 0.05;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  const auto reference = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view)).value();
  std::vector<std::vector<double>> covariances(8);
  std::vector<std::thread> threads;
  for (std::vector<double>& covariance : covariances) {
    threads.emplace_back([&] {
      covariance =
          MakeOutdoorLightingSource({})->Estimate(Observe(frame, view))->lighting.covariance;
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& covariance : covariances) {
    EXPECT_EQ(covariance, reference.lighting.covariance);
  }
}

}  // namespace
}  // namespace pleinair

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimation/lighting_prior.h"
#include "estimation/outdoor_lighting_source.h"
#include "tests/estimation/synthetic_view.h"

namespace pleinair::outdoor_lighting_source_hard_cases_test {
namespace {

using ::testing::HasSubstr;
using testing::MakeFrame;
using testing::MakeView;
using ::testing::Not;
using testing::Observe;
using ::testing::StartsWith;
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

// Overexposed but for a corner: the next frame has all the places that it shows.
TEST(OutdoorLightingSourceHardCases, ABadFirstFrameDoesNotLimitTheNextOnes) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  const Frame good = MakeFrame(picture, view);
  Frame bad = good;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (x > picture.width / 3) bad.unusable.At(x, y) = kUnusable;
    }
  }
  const auto source = MakeOutdoorLightingSource({});
  ASSERT_TRUE(source->Estimate(Observe(bad, view)));
  const auto fresh = MakeOutdoorLightingSource({});
  const auto expected = fresh->Estimate(Observe(good, view));
  const auto estimate = source->Estimate(Observe(good, view));
  ASSERT_TRUE(estimate && expected);
  EXPECT_EQ(estimate->samples_used, expected->samples_used);
}

TEST(OutdoorLightingSourceHardCases, WithoutAUsablePixelThePriorAnswersOrTheReasonIsStated) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  std::fill(frame.unusable.pixels.begin(), frame.unusable.pixels.end(), 1);
  const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value());
  ExpectSane(*estimate);
  EXPECT_EQ(estimate->samples_used, 0);
  EXPECT_FALSE(estimate->sun_observable);
  // No sun and the whole beam are both within two deviations.
  const double sigma = std::sqrt(estimate->lighting.covariance[0]);
  EXPECT_LT(estimate->lighting.sun.irradiance_rgb.x, 2.0 * sigma);
  EXPECT_LT(850.0 - estimate->lighting.sun.irradiance_rgb.x, 2.0 * sigma);

  LightingObservation unknown = Observe(frame, view);
  unknown.clear_sky.absolute = false;
  const auto failure = MakeOutdoorLightingSource({})->Estimate(unknown);
  ASSERT_FALSE(failure.has_value());
  EXPECT_THAT(failure.error().reason, StartsWith("no usable sample: "));
  EXPECT_THAT(failure.error().reason, HasSubstr("environment.image"));

  // A clear sky in units that the picture's are not known in.
  LightingObservation relative = Observe(frame, view);
  frame.units = LightUnits::kRelativePerFrame;
  const auto no_exposure = MakeOutdoorLightingSource({})->Estimate(relative);
  ASSERT_FALSE(no_exposure.has_value());
  EXPECT_THAT(no_exposure.error().reason, HasSubstr("the frame's exposure"));

  LightingObservation night = relative;
  night.clear_sky = {};
  const auto dark = MakeOutdoorLightingSource({})->Estimate(night);
  ASSERT_FALSE(dark.has_value());
  EXPECT_THAT(dark.error().reason, Not(HasSubstr("fall back")));
}

// A moving camera looks at the sky for one frame.
TEST(OutdoorLightingSourceHardCases, AFrameWithoutSurfacesDoesNotEndTheMeasuring) {
  SyntheticPicture picture;
  const auto source = MakeOutdoorLightingSource({});
  const auto look = [&](double east_m, bool at_sky) {
    SurfaceView view = MakeView(picture);
    view.camera.camera_from_world[3][0] = -east_m;
    if (at_sky) {
      std::fill(view.region.pixels.begin(), view.region.pixels.end(), SurfaceView::kNoRegion);
      std::fill(view.may_be_sampled.pixels.begin(), view.may_be_sampled.pixels.end(), 0);
    }
    const Frame frame = MakeFrame(picture, view);
    EXPECT_EQ(source->PixelsLookedAt(view.camera), std::nullopt);
    return source->Estimate(Observe(frame, view));
  };
  ASSERT_GT(look(0.0, false)->samples_used, 400);
  EXPECT_EQ(look(0.1, true)->samples_used, 0);
  picture.sun *= 0.1;
  const auto after = look(0.2, false);
  EXPECT_GT(after->samples_used, 400);
  EXPECT_LT(after->lighting.sun.irradiance_rgb.y, 0.2 * SyntheticPicture().sun.y);
}

double SunError(const LightingEstimate& estimate, const SyntheticPicture& picture) {
  return std::abs(estimate.lighting.sun.irradiance_rgb.y / picture.sun.y - 1.0);
}

// The model's sun turned about the vertical: n.l of the wall is off by as much, lit or not, and n.l
// of the ground is not.
TEST(OutdoorLightingSourceHardCases, ASunInTheWrongPlaceErrsInProportionAndLeavesAResidual) {
  const SyntheticPicture picture;
  const SurfaceView truth = MakeView(picture);
  const Frame frame = MakeFrame(picture, truth);
  double last_residual = 0.0;
  double last_inliers = 1.1;
  double exact = 0.0;
  for (const double degrees : {0.0, 1.0, 2.0, 4.0}) {
    LightingObservation observation = Observe(frame, truth);
    const double turn = degrees * std::numbers::pi / 180.0;
    const glm::dvec3 sun = truth.sun_direction_enu;
    observation.sun.direction_enu = {std::cos(turn) * sun.x - std::sin(turn) * sun.y,
                                     std::sin(turn) * sun.x + std::cos(turn) * sun.y,
                                     sun.z};
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(observation);
    ASSERT_TRUE(estimate.has_value());
    if (degrees == 0.0) exact = SunError(*estimate, picture);
    // On a wall 45 deg from the sun a degree is 1.7 % of n.l.
    EXPECT_LE(SunError(*estimate, picture), exact + 0.02 * degrees) << degrees;
    // Where the rest fits well, a wall that does not is left out, and stays out.
    EXPECT_TRUE(estimate->relative_residual > last_residual ||
                estimate->inlier_fraction < last_inliers || last_inliers < 0.8)
        << degrees;
    EXPECT_LE(estimate->inlier_fraction, last_inliers);
    last_residual = estimate->relative_residual;
    last_inliers = estimate->inlier_fraction;
  }
}

// A mesh or a pose a little off moves the model's shadow edge over the picture: what it gets wrong
// are outliers, as many as the strip is wide.
TEST(OutdoorLightingSourceHardCases, AShadowEdgeInTheWrongPlaceIsLeftOut) {
  SyntheticPicture picture;
  const Frame frame = MakeFrame(picture, MakeView(picture));
  double inliers = 1.1;
  for (const double off : {0.0, 0.05, 0.1}) {
    SyntheticPicture model = picture;
    model.shadow_share += off;
    const SurfaceView view = MakeView(model);
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
    ASSERT_TRUE(estimate.has_value());
    EXPECT_LT(SunError(*estimate, picture), 0.01) << off;
    EXPECT_LT(estimate->inlier_fraction, inliers) << off;
    inliers = estimate->inlier_fraction;
  }
}

TEST(OutdoorLightingSourceHardCases, APictureThatTheModelDoesNotExplainIsSaid) {
  const SyntheticPicture picture;
  const SurfaceView truth = MakeView(picture);
  Frame frame = MakeFrame(picture, truth);
  const auto fits = MakeOutdoorLightingSource({})->Estimate(Observe(frame, truth));
  ASSERT_TRUE(fits.has_value());
  EXPECT_FALSE(ModelMismatch(*fits));
  // Bands of another colour, wider than a footprint.
  for (int y = 0; y < frame.radiance.height; ++y) {
    const float band = y / 9 % 3 == 0 ? 0.4f : y / 9 % 3 == 1 ? 1.0f : 1.9f;
    for (int x = 0; x < frame.radiance.width; ++x) frame.radiance.At(x, y) *= band;
  }
  const auto does_not = MakeOutdoorLightingSource({})->Estimate(Observe(frame, truth));
  ASSERT_TRUE(does_not.has_value());
  ExpectSane(*does_not);
  EXPECT_TRUE(ModelMismatch(*does_not));
  // Nor is its light stated as if it did.
  const Lighting& light = does_not->lighting;
  const double all = light.sun.irradiance_rgb.g + light.SkyIrradianceRgb().g;
  const double excess =
      std::sqrt(std::pow(does_not->relative_residual, 2) - std::pow(kLargestTrustedResidual, 2));
  EXPECT_GT(excess, 0.1);
  const std::size_t unknowns = 3 * (1 + light.sky.size());
  double of_sky = 0.0;
  for (std::size_t i = 4; i < unknowns; i += 3) {
    for (std::size_t j = 4; j < unknowns; j += 3) of_sky += light.covariance[i * unknowns + j];
  }
  EXPECT_GE(std::sqrt(light.covariance[unknowns + 1]), 0.99 * excess * all);
  EXPECT_GE(std::sqrt(of_sky), 0.99 * excess * all);
}

// Water halves what paving sends back; a half of the paving is wet.
TEST(OutdoorLightingSourceHardCases, WetGroundIsLeftOutCoveredOrSaid) {
  SyntheticPicture picture;
  picture.noise = 0.03;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  for (int y = frame.radiance.height / 2; y < frame.radiance.height; ++y) {
    for (int x = 0; x < frame.radiance.width; ++x) {
      if (x / 20 % 2 == 0) frame.radiance.At(x, y) *= 0.5f;
    }
  }
  const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value());
  ExpectSane(*estimate);
  for (std::size_t c = 0; c < 3; ++c) {
    const int channel = static_cast<int>(c);
    const double off = estimate->lighting.sun.irradiance_rgb[channel] - picture.sun[channel];
    EXPECT_TRUE(std::abs(off) < 3.0 * std::sqrt(estimate->lighting.covariance[7 * c]) ||
                ModelMismatch(*estimate));
  }
}

// A hundred-thousandth of the day's light, and no beam in it; the sun just above the horizon, where
// the clear sky would have one, and below.
TEST(OutdoorLightingSourceHardCases, DuskAndNightHaveNoConfidentSun) {
  for (const double sun_elevation_deg : {1.0, -3.0}) {
    SyntheticPicture picture;
    picture.sun = glm::dvec3(0.0);
    picture.sky *= 1e-5;
    picture.noise = 0.05;
    SurfaceView view = MakeView(picture);
    const double elevation = sun_elevation_deg * std::numbers::pi / 180.0;
    view.sun_direction_enu = {-std::cos(elevation), 0.0, std::sin(elevation)};
    const Frame frame = MakeFrame(picture, view);
    LightingObservation observation = Observe(frame, view);
    const double beam = sun_elevation_deg > 0.0 ? 10.0 : 0.0;
    observation.clear_sky.beam_rgb = glm::dvec3(beam);
    observation.clear_sky.diffuse_rgb = glm::dvec3(5.0);
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(observation);
    ASSERT_TRUE(estimate.has_value());
    ExpectSane(*estimate);
    for (std::size_t c = 0; c < 3; ++c) {
      const int channel = static_cast<int>(c);
      const double sun = estimate->lighting.sun.irradiance_rgb[channel];
      const double sigma = std::sqrt(estimate->lighting.covariance[7 * c]);
      EXPECT_LE(sun, 3.0 * sigma) << sun_elevation_deg;
      // No more than what would still be darker than the sky.
      if (estimate->sun_observable) {
        EXPECT_LT(sun, 0.05 * beam);
      }
    }
    if (sun_elevation_deg < 0.0) {
      EXPECT_EQ(estimate->lighting.sun.irradiance_rgb, glm::dvec3(0.0));
      EXPECT_FALSE(estimate->sun_observable);
    }
  }
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
  threads.reserve(covariances.size());
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
}  // namespace pleinair::outdoor_lighting_source_hard_cases_test

#include "estimation/outdoor_lighting_source.h"

#include <chrono>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "scene/state_id.h"
#include "tests/estimation/synthetic_view.h"

namespace pleinair::outdoor_lighting_source_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::MakeFrame;
using testing::MakeView;
using testing::Observe;
using testing::SyntheticPicture;

TEST(OutdoorLightingSource, FindsSunAndSkyInAPicture) {
  SyntheticPicture picture;
  picture.noise = 0.05;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
  ASSERT_TRUE(estimate.has_value());
  const Lighting& lighting = estimate->lighting;
  for (int c = 0; c < 3; ++c) {
    // 5 % over footprints of 25 pixels, 250 of them lit: 0.1 %; the prior's pull is as much again.
    EXPECT_NEAR(lighting.sun.irradiance_rgb[c], picture.sun[c], 0.01 * picture.sun[c]);
    EXPECT_NEAR(lighting.SkyIrradianceRgb()[c], picture.sky[c], 0.02 * picture.sky[c]);
  }
  EXPECT_TRUE(estimate->sun_observable);
  EXPECT_EQ(estimate->samples_used, 500);
  EXPECT_GT(estimate->inlier_fraction, 0.95);
  EXPECT_EQ(lighting.covariance.size(), 36u);
  EXPECT_EQ(lighting.time, frame.time);
  EXPECT_EQ(lighting.sun.direction_enu, view.sun_direction_enu);
  EXPECT_GT(estimate->new_sample_set_ms, 0.0);
}

// Three shapes that the picture cannot distinguish: the clear one has a third of the sky under
// nearly a clear sky's sun, and nothing behind cloud.
TEST(OutdoorLightingSource, AnOvercastSkyIsNotClear) {
  for (const bool is_overcast : {true, false}) {
    SyntheticPicture picture;
    if (is_overcast) picture.sun = glm::dvec3(0.0);
    SurfaceView view = MakeView(picture);
    view.sky_shape_names = {"uniform", "overcast", "clear"};
    view.sky_response.resize(3, view.sky_response[0]);
    const Frame frame = MakeFrame(picture, view);
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(Observe(frame, view));
    ASSERT_TRUE(estimate.has_value());
    const glm::dvec3 clear = estimate->lighting.sky[2].irradiance_rgb / picture.sky;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(clear[c], is_overcast ? 0.0 : 1.0 / 3.0, 0.05) << is_overcast;
    }
  }
}

TEST(OutdoorLightingSource, KeepsItsSamplesWhileCameraAndSunStandStill) {
  const SyntheticPicture picture;
  SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  const auto source = MakeOutdoorLightingSource({});
  EXPECT_GT(source->Estimate(Observe(frame, view))->new_sample_set_ms, 0.0);
  frame.time += milliseconds(33);
  EXPECT_EQ(source->Estimate(Observe(frame, view))->new_sample_set_ms, 0.0);
  view.sun_id = StateId::Next();
  EXPECT_GT(source->Estimate(Observe(frame, view))->new_sample_set_ms, 0.0);
  view.geometry_id = StateId::Next();
  EXPECT_GT(source->Estimate(Observe(frame, view))->new_sample_set_ms, 0.0);
  EXPECT_EQ(source->Estimate(Observe(frame, view))->new_sample_set_ms, 0.0);
}

// A first frame that is clipped all over must not leave the next one without samples.
TEST(OutdoorLightingSource, DrawsAgainWhenAFrameLeftTheSetShort) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame clipped = MakeFrame(picture, view);
  std::fill(clipped.unusable.pixels.begin(), clipped.unusable.pixels.end(), 1);
  const auto source = MakeOutdoorLightingSource({});
  EXPECT_EQ(source->Estimate(Observe(clipped, view))->samples_used, 0);
  const Frame frame = MakeFrame(picture, view);
  EXPECT_EQ(source->Estimate(Observe(frame, view))->samples_used, 500);
}

// And a kept set that loses much of itself to clipping is replaced.
TEST(OutdoorLightingSource, DrawsAgainWhenAFrameSpoilsTheSet) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  const auto source = MakeOutdoorLightingSource({});
  ASSERT_TRUE(source->Estimate(Observe(frame, view)).has_value());
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width / 4; ++x) frame.unusable.At(x, y) = 1;
  }
  const auto estimate = source->Estimate(Observe(frame, view));
  EXPECT_GT(estimate->new_sample_set_ms, 0.0);
  EXPECT_EQ(estimate->samples_used, 500);
}

// A well-posed frame is not held back by the one before it: no filter hides in the prior.
TEST(OutdoorLightingSource, FollowsACloudInTheFrameThatShowsIt) {
  SyntheticPicture clear;
  SyntheticPicture covered = clear;
  covered.sun = glm::dvec3(0.0);
  const SurfaceView view = MakeView(clear);
  const auto source = MakeOutdoorLightingSource({});
  Frame frame = MakeFrame(clear, view);
  ASSERT_TRUE(source->Estimate(Observe(frame, view)).has_value());
  const UtcTime next = frame.time + milliseconds(33);
  frame = MakeFrame(covered, view);
  frame.time = next;
  const auto estimate = source->Estimate(Observe(frame, view));
  EXPECT_LT(estimate->lighting.sun.irradiance_rgb.x, 0.03 * clear.sun.x);
}

// The camera turns to a shaded corner: the last sun is carried on, ever less sure, and fades.
TEST(OutdoorLightingSource, CarriesTheSunOnWhereItIsNotSeen) {
  SyntheticPicture seen;
  SyntheticPicture unseen = seen;
  unseen.shadow_share = 1.0;
  const SurfaceView seen_view = MakeView(seen);
  SurfaceView unseen_view = MakeView(unseen);
  unseen_view.geometry_id = StateId::Next();
  std::fill(
      unseen_view.sun_bounce.pixels.begin(), unseen_view.sun_bounce.pixels.end(), glm::vec3(0.0f));
  const Frame seen_frame = MakeFrame(seen, seen_view);
  Frame unseen_frame = MakeFrame(unseen, unseen_view);
  const auto source = MakeOutdoorLightingSource({});
  const double sun =
      source->Estimate(Observe(seen_frame, seen_view))->lighting.sun.irradiance_rgb.x;

  const auto after = [&](auto gap) {
    unseen_frame.time = seen_frame.time + gap;
    return source->Estimate(Observe(unseen_frame, unseen_view)).value();
  };
  double last_sigma = 0.0;
  double last_sun = sun;
  for (int step = 1; step <= 60; ++step) {
    const LightingEstimate estimate = after(seconds(2 * step));
    EXPECT_FALSE(estimate.sun_observable);
    const double now = estimate.lighting.sun.irradiance_rgb.x;
    EXPECT_LT(std::abs(now - last_sun), 0.05 * sun) << step;  // Never a jump.
    EXPECT_GE(std::sqrt(estimate.lighting.covariance[0]), last_sigma * 0.98) << step;
    last_sigma = std::sqrt(estimate.lighting.covariance[0]);
    last_sun = now;
    if (step == 1) {
      EXPECT_NEAR(now, sun, 0.1 * sun);
      EXPECT_LT(last_sigma, 0.25 * sun);
    }
  }
  // A clear day does not end within two minutes, and is no longer certain.
  EXPECT_NEAR(last_sun, sun, 0.25 * sun);
  // Days later the weather may be any, as far as the sky's light allows.
  const Lighting later = after(std::chrono::hours(24 * 10)).lighting;
  EXPECT_GT(std::sqrt(later.covariance[0]), 1.5 * last_sigma);
}

TEST(OutdoorLightingSource, WithoutASurveyTheRatioOfTheClearSkyHelps) {
  SyntheticPicture picture;
  picture.shadow_share = 0.0;  // All in sun: wall and ground separate sun and sky only roughly.
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  LightingObservation observation = Observe(frame, view);
  observation.clear_sky.absolute = false;
  for (const double scale : {1.0, 1e-3, 1e3}) {
    Frame scaled = frame;
    for (glm::vec3& pixel : scaled.radiance.pixels) pixel *= static_cast<float>(scale);
    const LightingObservation relative{scaled, view, observation.sun, observation.clear_sky};
    const auto estimate = MakeOutdoorLightingSource({})->Estimate(relative);
    ASSERT_TRUE(estimate.has_value());
    const Lighting& lighting = estimate->lighting;
    EXPECT_NEAR(lighting.sun.irradiance_rgb.x,
                scale * picture.sun.x,
                3.0 * std::sqrt(lighting.covariance[0]));
    EXPECT_LT(std::sqrt(lighting.covariance[0]), 0.4 * scale * picture.sun.x);
  }
}

TEST(OutdoorLightingSource, RefusesImpossibleOptions) {
  EXPECT_THROW(MakeOutdoorLightingSource({0, 1}), std::invalid_argument);
  EXPECT_THROW(MakeOutdoorLightingSource({100001, 1}), std::invalid_argument);
}

// Light goes as one over albedo: with all albedos off by a tenth, all lights are.
TEST(OutdoorLightingSource, AlbedoErrorsThatAllSamplesShareWidenTheLight) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  LightingObservation observation = Observe(frame, view);
  const auto estimate = [&] {
    return MakeOutdoorLightingSource({})->Estimate(observation).value().lighting;
  };
  const Lighting exact = estimate();
  observation.albedo_stddev_rgb = {0.1, 0.2, 0.0};
  const Lighting scaled = estimate();
  EXPECT_EQ(exact.sun.irradiance_rgb, scaled.sun.irradiance_rgb);
  const std::size_t side = 3 * (1 + exact.sky.size());
  for (std::size_t c = 0; c < 3; ++c) {
    const auto channel = static_cast<int>(c);
    const double shared =
        observation.albedo_stddev_rgb[channel] * exact.sun.irradiance_rgb[channel];
    EXPECT_NEAR(scaled.covariance[c * (side + 1)],
                exact.covariance[c * (side + 1)] + shared * shared,
                1e-9 * shared * shared + 1e-12 * exact.covariance[c * (side + 1)]);
  }
}

}  // namespace
}  // namespace pleinair::outdoor_lighting_source_test

#include "estimation/fisheye_lighting_source.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/estimation/synthetic_fisheye.h"
#include "tests/estimation/synthetic_view.h"

namespace pleinair::fisheye_lighting_source_test {
namespace {

using testing::FisheyePicture;
using testing::MakeFisheyePicture;
using testing::MakeFrame;
using testing::MakeView;
using testing::Observe;
using testing::SkyCamera;
using testing::SyntheticPicture;

constexpr double kDiscSr = std::numbers::pi * kMeanSunAngularRadiusRad * kMeanSunAngularRadiusRad;

struct Scene {
  FisheyePicture fisheye;
  SyntheticPicture picture;
  SurfaceView view;
  Frame frame;

  Scene() {
    view = MakeView(picture);
    fisheye.sun_direction_enu = view.sun_direction_enu;
    fisheye.sun_radiance = picture.sun / kDiscSr;
    frame = MakeFrame(picture, view);
    frame.fisheye_radiance = MakeFisheyePicture(fisheye);
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate() {
    const auto source =
        MakeFisheyeLightingSource(SkyCamera(fisheye.side_px), FisheyeLightingOptions());
    const auto basis = source->BasisFor(frame, {view.sun_direction_enu});
    if (!basis) return tl::unexpected(basis.error());
    EXPECT_EQ(basis->size(), 1u);
    return source->Estimate(Observe(frame, view));
  }
};

TEST(FisheyeLightingSource, SeparatesSunSkyAndRegions) {
  Scene scene;
  const auto estimate = scene.Estimate();
  ASSERT_TRUE(estimate.has_value());
  const Lighting& lighting = estimate->lighting;
  for (int c = 0; c < 3; ++c) {
    // The picture's own sampling of the disc, see fisheye_sky_test.cpp.
    EXPECT_NEAR(lighting.sun.irradiance_rgb[c], scene.picture.sun[c], 0.02 * scene.picture.sun[c]);
  }
  // The integral of (30 - 15 y + 8 z) z over the hemisphere: 30 pi + 8 2 pi / 3.
  const double expected = 30.0 * std::numbers::pi + 16.0 * std::numbers::pi / 3.0;
  EXPECT_NEAR(lighting.SkyIrradianceRgb().y, expected, 2e-3 * expected);
  EXPECT_EQ(estimate->sky_radiance_rgb.size(), 64u);
  EXPECT_TRUE(estimate->sun_observable);
  EXPECT_EQ(lighting.covariance.size(), 36u);
  EXPECT_EQ(lighting.time, scene.frame.time);
}

// 500 samples of a clean picture, their own sky held at what the fish-eye says it is.
TEST(FisheyeLightingSource, AClippedDiscIsMeasuredBySunPatchesInTheFramesOwnPicture) {
  Scene scene;
  const auto sky = scene.Estimate()->lighting.SkyIrradianceRgb();
  scene.picture.sky = sky;
  const RgbImage fisheye = [&] {
    FisheyePicture spread = scene.fisheye;
    spread.spread_px = 2.0;
    RgbImage clipped = MakeFisheyePicture(spread);
    for (glm::vec3& pixel : clipped.pixels) pixel = glm::min(pixel, glm::vec3(200.0f));
    return clipped;
  }();
  scene.frame = MakeFrame(scene.picture, scene.view);
  scene.frame.fisheye_radiance = fisheye;
  const auto estimate = scene.Estimate();
  ASSERT_TRUE(estimate.has_value());
  EXPECT_GT(estimate->samples_used, 100);
  for (int c = 0; c < 3; ++c) {
    const double sun = scene.picture.sun[c];
    EXPECT_NEAR(estimate->lighting.sun.irradiance_rgb[c], sun, 0.02 * sun);
  }
  EXPECT_TRUE(estimate->sun_observable);
}

// Nothing lit in view: the clear-sky beam, half of it give or take a third, is all there is.
TEST(FisheyeLightingSource, AClippedDiscWithoutSunPatchesIsUncertain) {
  Scene scene;
  for (std::uint8_t& may : scene.view.may_be_sampled.pixels) may = 0;
  scene.fisheye.spread_px = 2.0;
  RgbImage clipped = MakeFisheyePicture(scene.fisheye);
  for (glm::vec3& pixel : clipped.pixels) pixel = glm::min(pixel, glm::vec3(200.0f));
  scene.frame.fisheye_radiance = clipped;
  const auto estimate = scene.Estimate();
  ASSERT_TRUE(estimate.has_value());
  EXPECT_FALSE(estimate->sun_observable);
  const double beam = testing::SyntheticClearSky().beam_rgb.y;
  const double sigma = std::sqrt(estimate->lighting.covariance[7]);
  EXPECT_GT(sigma, 0.2 * beam);
  EXPECT_LT(std::abs(estimate->lighting.sun.irradiance_rgb.y - beam), 2.0 * sigma);
}

// Whole or clipped: the caller can say so, and the sun is not taken for well known.
TEST(FisheyeLightingSource, ASunElsewhereIsSaidAndIsUncertain) {
  for (const float limit : {1e9f, 5e5f}) {
    Scene scene;
    scene.fisheye.PutSunAt(20.0, 35.0);
    scene.fisheye.spread_px = 1.0;
    RgbImage picture = MakeFisheyePicture(scene.fisheye);
    for (glm::vec3& pixel : picture.pixels) pixel = glm::min(pixel, glm::vec3(limit));
    scene.frame.fisheye_radiance = picture;
    const auto estimate = scene.Estimate();
    ASSERT_TRUE(estimate.has_value());
    ASSERT_TRUE(estimate->sun_elsewhere_enu) << limit;
    EXPECT_GT(glm::dot(*estimate->sun_elsewhere_enu, scene.fisheye.sun_direction_enu), 0.9999);
    EXPECT_FALSE(estimate->sun_observable) << limit;
    if (limit < 1e9f) continue;
    const double sun = estimate->lighting.sun.irradiance_rgb.y;
    EXPECT_NEAR(sun, scene.picture.sun.y, 0.02 * scene.picture.sun.y);
    EXPECT_GE(std::sqrt(estimate->lighting.covariance[7]), 0.4 * sun);
  }
}

TEST(FisheyeLightingSource, AFrameWithoutAPictureFails) {
  Scene scene;
  scene.frame.fisheye_radiance.reset();
  const auto estimate = scene.Estimate();
  ASSERT_FALSE(estimate.has_value());
  EXPECT_NE(estimate.error().reason.find("fish-eye"), std::string::npos);
}

TEST(FisheyeLightingSource, RefusesNoSamples) {
  FisheyeLightingOptions options;
  options.samples = 0;
  EXPECT_THROW(MakeFisheyeLightingSource(SkyCamera(64), options), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::fisheye_lighting_source_test

#include "estimation/fisheye_lighting_source.h"

#include <algorithm>
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

// A picture of the room or courtyard that the fish-eye's own light explains.
struct AgreeingScene : Scene {
  glm::dvec3 sky{0.0};
  AgreeingScene() {
    sky = Estimate()->lighting.SkyIrradianceRgb();
    picture.sky = sky;
    frame.radiance = MakeFrame(picture, view).radiance;
  }
};

double LargestOff(const Lighting& lighting, const glm::dvec3& sun, const glm::dvec3& sky) {
  double off = 0.0;
  for (int c = 0; c < 3; ++c) {
    off = std::max({off,
                    std::abs(lighting.sun.irradiance_rgb[c] / sun[c] - 1.0),
                    std::abs(lighting.SkyIrradianceRgb()[c] / sky[c] - 1.0)});
  }
  return off;
}

// A wrong exposure and other colours: the surfaces in the frame's own picture show both.
TEST(FisheyeLightingSource, LightInOtherUnitsIsScaledToThePicture) {
  AgreeingScene scene;
  ASSERT_FALSE(scene.Estimate()->sky_camera.is_in_other_units);
  for (glm::vec3& pixel : scene.frame.fisheye_radiance->pixels) {
    pixel *= glm::vec3(0.02f, 0.01f, 0.005f);
  }
  const auto estimate = scene.Estimate();
  ASSERT_TRUE(estimate.has_value());
  EXPECT_TRUE(estimate->sky_camera.is_in_other_units);
  EXPECT_FALSE(estimate->sky_camera.shows_another_sun);
  EXPECT_NEAR(estimate->sky_camera.factor_rgb.g, 100.0, 3.0);
  EXPECT_LT(LargestOff(estimate->lighting, scene.picture.sun, scene.sky), 0.05);
  // As sure as albedos are, not as a picture of the sky.
  EXPECT_GT(std::sqrt(estimate->lighting.covariance[7]), 0.1 * scene.picture.sun.g);
}

// Albedos that are a quarter off are no evidence against the fish-eye's units.
TEST(FisheyeLightingSource, AlbedosThatErrDoNotScaleTheLight) {
  AgreeingScene scene;
  for (glm::vec3& pixel : scene.frame.radiance.pixels) pixel *= 1.25f;
  const auto estimate = scene.Estimate();
  EXPECT_EQ(estimate->sky_camera.factor_rgb, glm::dvec3(1.0));
  EXPECT_LT(LargestOff(estimate->lighting, scene.picture.sun, scene.sky), 0.03);
}

TEST(FisheyeLightingSource, LightOfAnUnknownExposureIsInThePicturesUnits) {
  AgreeingScene scene;
  for (glm::vec3& pixel : scene.frame.radiance.pixels) pixel *= 0.003f;
  scene.frame.units = LightUnits::kRelativePerFrame;
  const auto estimate = scene.Estimate();
  ASSERT_TRUE(estimate.has_value());
  EXPECT_EQ(estimate->units, LightUnits::kRelativePerFrame);
  EXPECT_FALSE(estimate->sky_camera.is_in_other_units);
  EXPECT_LT(LargestOff(estimate->lighting, 0.003 * scene.picture.sun, 0.003 * scene.sky), 0.05);
  // Nothing to scale it to.
  for (std::uint8_t& may : scene.view.may_be_sampled.pixels) may = 0;
  const auto nothing = scene.Estimate();
  ASSERT_FALSE(nothing.has_value());
  EXPECT_NE(nothing.error().reason.find("exposure"), std::string::npos);
}

// A bird on the dome, or a sky camera that has stopped: the patches of sun show it.
TEST(FisheyeLightingSource, ASunThatTheSurfacesContradictIsMeasuredOnThem) {
  AgreeingScene scene;
  scene.fisheye.sun_radiance *= 0.01;
  scene.frame.fisheye_radiance = MakeFisheyePicture(scene.fisheye);
  const auto hidden = scene.Estimate();
  ASSERT_TRUE(hidden.has_value());
  EXPECT_TRUE(hidden->sky_camera.shows_another_sun);
  EXPECT_TRUE(hidden->sun_observable);
  EXPECT_LT(LargestOff(hidden->lighting, scene.picture.sun, scene.sky), 0.05);

  scene.fisheye.sun_radiance *= 100.0;
  scene.frame.fisheye_radiance = MakeFisheyePicture(scene.fisheye);
  scene.picture.sun = glm::dvec3(0.0);
  scene.frame.radiance = MakeFrame(scene.picture, scene.view).radiance;
  const auto old = scene.Estimate();
  ASSERT_TRUE(old.has_value());
  EXPECT_TRUE(old->sky_camera.shows_another_sun);
  EXPECT_LT(old->lighting.sun.irradiance_rgb.g, 0.03 * scene.sky.g);
}

// Both at once: a bird on the dome of a camera with another gain.
TEST(FisheyeLightingSource, AHiddenSunInOtherUnitsIsMeasuredOnTheSurfaces) {
  AgreeingScene scene;
  scene.fisheye.sun_radiance *= 0.01;
  scene.frame.fisheye_radiance = MakeFisheyePicture(scene.fisheye);
  for (glm::vec3& pixel : scene.frame.fisheye_radiance->pixels) pixel *= 0.1f;
  const auto estimate = scene.Estimate();
  ASSERT_TRUE(estimate.has_value());
  EXPECT_TRUE(estimate->sky_camera.shows_another_sun);
  EXPECT_LT(LargestOff(estimate->lighting, scene.picture.sun, scene.sky), 0.1);
  // As sure as the albedos.
  EXPECT_GT(std::sqrt(estimate->lighting.covariance[7]), 0.09 * scene.picture.sun.g);
}

TEST(FisheyeLightingSource, AClippedSunOfAnUnknownExposureIsInThePicturesUnits) {
  AgreeingScene scene;
  scene.fisheye.spread_px = 2.0;
  scene.frame.fisheye_radiance = MakeFisheyePicture(scene.fisheye);
  for (glm::vec3& pixel : scene.frame.fisheye_radiance->pixels) {
    pixel = glm::min(pixel, glm::vec3(200.0f));
  }
  for (glm::vec3& pixel : scene.frame.radiance.pixels) pixel *= 0.003f;
  scene.frame.units = LightUnits::kRelativePerFrame;
  const auto estimate = scene.Estimate();
  ASSERT_TRUE(estimate.has_value());
  EXPECT_LT(LargestOff(estimate->lighting, 0.003 * scene.picture.sun, 0.003 * scene.sky), 0.1);
}

TEST(FisheyeLightingSource, ANightIsDarkInAnyUnits) {
  Scene scene;
  for (glm::vec3& pixel : scene.frame.fisheye_radiance->pixels) pixel = glm::vec3(0.0f);
  for (const LightUnits units : {LightUnits::kAbsolute, LightUnits::kRelativePerFrame}) {
    scene.frame.units = units;
    scene.view.sun_direction_enu = {0.6, 0.0, -0.8};
    const auto estimate = scene.Estimate();
    ASSERT_TRUE(estimate.has_value());
    EXPECT_EQ(estimate->lighting.SkyIrradianceRgb(), glm::dvec3(0.0));
    for (const glm::dvec3& region : estimate->sky_radiance_rgb) EXPECT_EQ(region, glm::dvec3(0.0));
  }
}

TEST(FisheyeLightingSource, ABlackPictureByDayFails) {
  Scene scene;
  for (glm::vec3& pixel : scene.frame.fisheye_radiance->pixels) pixel = glm::vec3(0.0f);
  const auto estimate = scene.Estimate();
  ASSERT_FALSE(estimate.has_value());
  EXPECT_NE(estimate.error().reason.find("black"), std::string::npos);
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

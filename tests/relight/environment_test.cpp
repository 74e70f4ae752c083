#include "relight/volume/environment.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include <gtest/gtest.h>

#include "scene/lat_long.h"
#include "scene/sky_shape.h"

namespace pleinair::environment_test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// A map of `size` that shows nothing but sky, with one sky shape.
Survey OpenSky(LatLongSize size) {
  Survey survey;
  SurfaceView& view = survey.view;
  view.region = {size.width, size.height, SurfaceView::kNoRegion};
  view.normal_world = {size.width, size.height};
  view.albedo_rgb = {size.width, size.height};
  view.sun_visibility = {size.width, size.height};
  view.sun_bounce = {size.width, size.height};
  view.sky_response.assign(1, {size.width, size.height});
  return survey;
}

// The same with a surface in one pixel, known in all that the rendering equation asks for.
Survey OneSurface(int x, int y) {
  Survey survey = OpenSky({8, 4});
  SurfaceView& view = survey.view;
  view.region.At(x, y) = 0;
  view.normal_world.At(x, y) = {0.0f, 0.6f, 0.8f};
  view.albedo_rgb.At(x, y) = {0.5f, 0.25f, 0.125f};
  view.sky_response[0].At(x, y) = {0.7f, 0.6f, 0.5f};
  view.sun_visibility.At(x, y) = 0.5f;
  view.sun_bounce.At(x, y) = {0.1f, 0.2f, 0.3f};
  return survey;
}

// jensen-2006, the equation of section 4.2, with bounces: rho / pi (C P_sky + S P_sun). n.l = 0.8
// under a sun at the zenith. 1e-6 relative: six float operations.
TEST(Environment, SurfacesFollowTheRenderingEquation) {
  const Survey survey = OneSurface(3, 2);
  const glm::vec3 sky = EnvironmentOfSky(survey, 0, *MakeUniformSkyShape()).radiance.At(3, 2);
  EXPECT_NEAR(sky.x, 0.5f / kPi * 0.7f, 1e-7f);
  EXPECT_NEAR(sky.y, 0.25f / kPi * 0.6f, 1e-7f);
  EXPECT_NEAR(sky.z, 0.125f / kPi * 0.5f, 1e-7f);
  const glm::vec3 sun = EnvironmentOfSun(survey, {0.0, 0.0, 1.0}).radiance.At(3, 2);
  EXPECT_NEAR(sun.x, 0.5f / kPi * (0.5f * 0.8f + 0.1f), 1e-7f);
  EXPECT_NEAR(sun.y, 0.25f / kPi * (0.5f * 0.8f + 0.2f), 1e-7f);
  EXPECT_NEAR(sun.z, 0.125f / kPi * (0.5f * 0.8f + 0.3f), 1e-7f);
}

TEST(Environment, TheSunsDiscAndTheSkyItLightsAreNotInTheSunsMap) {
  const EnvironmentBasis sun = EnvironmentOfSun(OneSurface(3, 2), {0.0, 0.0, 1.0});
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      if (x == 3 && y == 2) continue;
      EXPECT_EQ(sun.radiance.At(x, y), glm::vec3(0.0f));
    }
  }
}

// A shape brings irradiance 1 to a horizontal plane; so must its picture. Midpoints of rows of
// height h integrate sin cos to h^2 / 6 relative: 2.5e-5 at 256 rows, twice that allowed.
TEST(Environment, TheMapOfASkyBringsItsIrradiance) {
  const LatLongSize size{512, 256};
  const EnvironmentBasis sky = EnvironmentOfSky(OpenSky(size), 0, *MakeUniformSkyShape());
  double irradiance = 0.0;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double cosine = DirectionFromLatLong({x + 0.5, y + 0.5}, size).z;
      irradiance += sky.radiance.At(x, y).y * std::abs(cosine) * LatLongPixelSolidAngleSr(y, size);
    }
  }
  EXPECT_NEAR(irradiance, 1.0, 5e-5);
}

// A value that no two pixels, lights or channels share.
RgbImage Pattern(int width, int height, int light) {
  RgbImage image(width, height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const auto pixel = static_cast<float>(i);
    const auto k = static_cast<float>(light + 1);
    image.pixels[i] = {std::sin(k * pixel) + 1.1f, std::cos(k * pixel) + 1.2f, k / (pixel + 1.0f)};
  }
  return image;
}

// Sizes with and without a rest of the inner loop's 4 pixels, of its 512-pixel blocks, and one that
// is shared out to threads. 4e-7 of the largest sum: three roundings of a float.
TEST(Environment, SynthesisIsTheSumOverLights) {
  Lighting lighting;
  lighting.sun.irradiance_rgb = {700.0, 650.0, 600.0};
  lighting.sky = {{"uniform", {100.0, 120.0, 150.0}}, {"clear", {20.0, 10.0, 5.0}}};
  for (const LatLongSize size : {LatLongSize{1, 1}, {7, 5}, {64, 32}, {512, 256}}) {
    std::vector<EnvironmentBasis> basis;
    for (int k = 0; k < 3; ++k) basis.push_back({Pattern(size.width, size.height, k)});
    RgbImage environment;
    SynthesiseEnvironment(basis, lighting, environment);
    ASSERT_EQ(environment.width, size.width);
    ASSERT_EQ(environment.height, size.height);
    for (std::size_t i = 0; i < environment.pixels.size(); ++i) {
      const glm::dvec3 expected =
          lighting.sun.irradiance_rgb * glm::dvec3(basis[0].radiance.pixels[i]) +
          lighting.sky[0].irradiance_rgb * glm::dvec3(basis[1].radiance.pixels[i]) +
          lighting.sky[1].irradiance_rgb * glm::dvec3(basis[2].radiance.pixels[i]);
      for (glm::length_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(environment.pixels[i][c], expected[c], 4e-7 * 2000.0) << i;
      }
    }
  }
}

TEST(Environment, SynthesisKeepsTheMapsMemory) {
  const std::vector<EnvironmentBasis> basis{{Pattern(64, 32, 0)}, {Pattern(64, 32, 1)}};
  Lighting lighting;
  lighting.sky.resize(1);
  RgbImage environment;
  SynthesiseEnvironment(basis, lighting, environment);
  const glm::vec3* const before = environment.pixels.data();
  SynthesiseEnvironment(basis, lighting, environment);
  EXPECT_EQ(environment.pixels.data(), before);
}

}  // namespace
}  // namespace pleinair::environment_test

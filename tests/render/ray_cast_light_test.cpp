// What ray casting says of the sun's disc and of mirror images, as the compositor takes it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/lens.h"
#include "composite_scene.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "test_scenes.h"

namespace pleinair::test::ray_cast_light_test {
namespace {

// Half float keeps 11 bits, and drivers may cut off instead of rounding: 2^-10.
constexpr double kHalfRounding = 1e-3;
constexpr float kIrradiance = 90.0f;

Material Glossy() {
  Material glossy;
  glossy.diffuse_albedo = {0.3f, 0.2f, 0.1f};
  glossy.specular_reflectance = {0.2f, 0.3f, 0.5f};
  glossy.roughness = 0.5f;
  return glossy;
}

class RayCastLightTest : public testing::TestWithParam<CompositeBy> {
 protected:
  RayCastLightTest() { compositor_.SetPhantom(scene_.phantom); }

  Composite Render(const Mesh& object, const SunShares* shares, const MirroredLight* mirrored) {
    compositor_.SetObjects({{object}});
    vertex_irradiance_ = {
        std::vector<glm::vec3>(object.positions_m.size(), glm::vec3(kIrradiance))};
    CompositeInput input = scene_.Input(vertex_irradiance_);
    input.sun_shares = shares;
    input.mirrored = mirrored;
    return compositor_.Render(input);
  }
  // Lit only by the sun, with all of its disc visible.
  Composite RenderInSun(const Mesh& object, const glm::dvec3& to_sun, double irradiance) {
    scene_.lighting.sun.irradiance_rgb = glm::dvec3(irradiance);
    scene_.lighting.sun.direction_enu = to_sun;
    compositor_.SetObjects({{object}});
    vertex_irradiance_ = {std::vector<glm::vec3>(object.positions_m.size(), glm::vec3(0.0f))};
    const MirroredLight nothing;
    const SunShares seen{{}, Everywhere(1.0f)};
    CompositeInput input = scene_.Input(vertex_irradiance_);
    input.sun_shares = &seen;
    input.mirrored = &nothing;
    return compositor_.Render(input);
  }
  // Grey, without diffuse light.
  static Material Mirror(float reflectance, float roughness) {
    Material mirror;
    mirror.diffuse_albedo = glm::vec3(0.0f);
    mirror.specular_reflectance = glm::vec3(reflectance);
    mirror.roughness = roughness;
    return mirror;
  }
  // The same share on all samples, of the entire picture.
  ObjectSunShare Everywhere(float seen) const {
    return {0,
            0,
            GrayImage(ObjectSunShare::kSamplesPerSide * scene_.view.Width(),
                      ObjectSunShare::kSamplesPerSide * scene_.view.Height(),
                      seen)};
  }

  HeadlessContext context_;
  Compositor compositor_{CompositorOptions{.composite_by = GetParam()}};
  CompositeScene scene_{DirectionOf(215.0, 40.0)};
  std::vector<std::vector<glm::vec3>> vertex_irradiance_;
  const Mesh sphere_ = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24);
};

TEST_P(RayCastLightTest, RealPixelsLoseTheShareOfTheDiscThatIsHidden) {
  SunShares shares{{60, 100, GrayImage(80, 70, 0.0f)}, Everywhere(1.0f)};
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < 80; ++x) shares.real.hidden.At(x, y) = static_cast<float>(x % 5) / 4.0f;
  }
  const Composite composite = Render(sphere_, &shares, nullptr);
  int scaled = 0;
  for (int y = 0; y < scene_.view.Height(); ++y) {
    for (int x = 0; x < scene_.view.Width(); ++x) {
      const std::size_t i = scene_.view.region.Index(x, y);
      if (composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kCovered)) continue;
      const bool is_inside = x >= 60 && x < 140 && y >= 100 && y < 170;
      const double hidden =
          is_inside ? static_cast<double>(shares.real.hidden.At(x - 60, y - 100)) : 0.0;
      const bool is_relit = hidden > 0.0 && scene_.view.sun_visibility.pixels[i] > 0.0f;
      ASSERT_EQ(composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kScaled),
                is_relit);
      if (!is_relit) {
        ASSERT_EQ(composite.radiance.pixels[i], scene_.radiance.pixels[i]);
        continue;
      }
      ++scaled;
      const glm::dvec3 expected = scene_.ModelRadiance(i, 1.0 - hidden);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(composite.radiance.pixels[i][c] / expected[c], 1.0, kHalfRounding);
      }
    }
  }
  EXPECT_GT(scaled, 1000);
}

// Sunlight on the object is the share times the unshadowed sunlight: sky and sun add up.
TEST_P(RayCastLightTest, AnObjectsSunIsTheShareThatItSees) {
  const SunShares dark{{}, Everywhere(0.0f)};
  const SunShares half{{}, Everywhere(0.5f)};
  const SunShares whole{{}, Everywhere(1.0f)};
  const Mesh object = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24, Glossy());
  const Composite without = Render(object, &dark, nullptr);
  const Composite with_half = Render(object, &half, nullptr);
  const Composite with_all = Render(object, &whole, nullptr);
  int lit = 0;
  for (std::size_t i = 0; i < without.change.pixels.size(); ++i) {
    if (without.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kCovered)) continue;
    for (int c = 0; c < 3; ++c) {
      const double low = without.radiance.pixels[i][c];
      const double high = with_all.radiance.pixels[i][c];
      // Sky and sun are added in half float, and their mean is rounded again.
      EXPECT_NEAR(with_half.radiance.pixels[i][c], 0.5 * (low + high), 2.0 * kHalfRounding * high);
    }
    lit += with_all.radiance.pixels[i].g > 1.5f * without.radiance.pixels[i].g ? 1 : 0;
  }
  EXPECT_GT(lit, 300);
}

// A glossy object in the dark: a diffuse part by its irradiance, and the mirror image as it is.
TEST_P(RayCastLightTest, AGlossyObjectShowsWhatItMirrors) {
  scene_.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
  const Material material = Glossy();
  const Mesh object = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24, material);
  MirroredLight mirrored{0, 0, RgbImage(scene_.view.Width(), scene_.view.Height())};
  for (int y = 0; y < mirrored.radiance.height; ++y) {
    for (int x = 0; x < mirrored.radiance.width; ++x) {
      mirrored.radiance.At(x, y) = glm::vec3(x % 7, y % 5, 3.0f);
    }
  }
  const Composite composite = Render(object, nullptr, &mirrored);
  int inside = 0;
  for (int y = 1; y + 1 < scene_.view.Height(); ++y) {
    for (int x = 1; x + 1 < scene_.view.Width(); ++x) {
      bool is_covered = true;
      for (int k = 0; k < 9; ++k) {
        is_covered &= composite.change.At(x + k % 3 - 1, y + k / 3 - 1) ==
                      static_cast<std::uint8_t>(PixelChange::kCovered);
      }
      if (!is_covered) continue;
      ++inside;
      const glm::vec3 expected = material.diffuse_albedo * kIrradiance / std::numbers::pi_v<float> +
                                 mirrored.radiance.At(x, y);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(composite.radiance.At(x, y)[c], expected[c], kHalfRounding * expected[c]);
      }
    }
  }
  EXPECT_GT(inside, 500);
}

TEST_P(RayCastLightTest, AMattObjectMirrorsNothing) {
  const MirroredLight mirrored{
      0, 0, RgbImage(scene_.view.Width(), scene_.view.Height(), glm::vec3(1e4f))};
  const Composite with = Render(sphere_, nullptr, &mirrored);
  const Composite without = Render(sphere_, nullptr, nullptr);
  EXPECT_EQ(with.radiance.pixels, without.radiance.pixels);
}

// 10^7 is a sun's disc in a mirror: nothing is brighter than what it mirrors, and no neighbour of
// it is spoilt.
TEST_P(RayCastLightTest, AMirroredSunStaysFinite) {
  const Mesh object = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 24, Glossy());
  const MirroredLight mirrored{
      0, 0, RgbImage(scene_.view.Width(), scene_.view.Height(), glm::vec3(1e7f))};
  const Composite composite = Render(object, nullptr, &mirrored);
  for (const glm::vec3& pixel : composite.radiance.pixels) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_TRUE(std::isfinite(pixel[c]));
      EXPECT_LE(pixel[c], 1e7f);
    }
  }
}

TEST_P(RayCastLightTest, RefusesSharesBeyondThePicture) {
  const SunShares shares{{200, 0, GrayImage(41, 10)}, {}};
  EXPECT_THROW(Render(sphere_, &shares, nullptr), std::invalid_argument);
}

// A ball of reflectance k and radius R (in pixels) sends the sun on evenly: its picture's sum is
// P k pi R^2 / (4 pi), the camera far off. The glint is smaller than a sample, and moves over the
// samples with the sun. 25 %: the ball is 8 radii away, where pictures of its near side are larger,
// a lobe between samples, and 96 rings of facets. No single picture may be lost or doubled.
TEST_P(RayCastLightTest, AGlintKeepsItsEnergyWhereverItFalls) {
  const Mesh ball = Sphere({0.0f, 0.0f, 1.0f}, 0.8f, 96, Mirror(0.8f, 0.1f));
  double mean = 0.0;
  constexpr int kSuns = 8;
  for (int i = 0; i < kSuns; ++i) {
    const Composite composite =
        RenderInSun(ball, DirectionOf(180.0 + 0.37 * i, 40.0 + 0.23 * i), 100.0);
    double sum = 0.0;
    int covered = 0;
    for (std::size_t p = 0; p < composite.change.pixels.size(); ++p) {
      const glm::vec3& pixel = composite.radiance.pixels[p];
      ASSERT_TRUE(std::isfinite(pixel.g));
      if (composite.change.pixels[p] != static_cast<std::uint8_t>(PixelChange::kCovered)) continue;
      ++covered;
      // The rim blends with the camera, which is dim beside the glint.
      if (pixel.g > 60.0f) sum += pixel.g;
    }
    const double expected = 100.0 * 0.8 * covered / (4.0 * std::numbers::pi);
    EXPECT_GT(sum, 0.5 * expected) << i;
    EXPECT_LT(sum, 1.7 * expected) << i;
    mean += sum / expected / kSuns;
  }
  EXPECT_NEAR(mean, 1.0, 0.25);
}

// What widens a glint, the disc and the turn of normals in a sample, does not reach far: beside it
// the material's own lobe is seen. 10 %: facets, and 1 / angle^4 averaged over pixels (5 %).
TEST_P(RayCastLightTest, BesideAGlintLightIsTheMaterialsOwn) {
  constexpr float kRoughness = 0.1f;
  constexpr double kReflectance = 0.8;
  constexpr double kSun = 1000.0;
  const glm::dvec3 centre(0.0, 0.0, 1.0);
  constexpr double kRadius = 0.8;
  const Mesh ball = Sphere(glm::vec3(centre),
                           static_cast<float>(kRadius),
                           192,
                           Mirror(static_cast<float>(kReflectance), kRoughness));
  const glm::dvec3 to_sun = DirectionOf(150.0, 40.0);
  const Composite composite = RenderInSun(ball, to_sun, kSun);

  const glm::dvec3 eye = scene_.Camera().CentreWorldM();
  const glm::dmat3 world_from_camera =
      glm::transpose(glm::dmat3(scene_.Camera().camera_from_world));
  constexpr double kAlpha2 = double{kRoughness} * kRoughness * kRoughness * kRoughness;
  double shown = 0.0;
  double expected = 0.0;
  for (int y = 0; y < scene_.view.Height(); ++y) {
    for (int x = 0; x < scene_.view.Width(); ++x) {
      const glm::dvec3 ray = glm::normalize(
          world_from_camera * *DirectionFromPixel(scene_.Camera().intrinsics, {x, y}));
      const double along = glm::dot(centre - eye, ray);
      const double off2 = glm::dot(centre - eye, centre - eye) - along * along;
      if (off2 > 0.8 * kRadius * kRadius) continue;  // Away from the rim.
      const glm::dvec3 hit = eye + (along - std::sqrt(kRadius * kRadius - off2)) * ray;
      const glm::dvec3 n = (hit - centre) / kRadius;
      const glm::dvec3 h = glm::normalize(to_sun - ray);
      const double n_l = glm::dot(n, to_sun);
      const double n_v = -glm::dot(n, ray);
      const double sin_h = glm::length(glm::cross(n, h));
      if (n_l < 0.1 || n_v < 0.1 || sin_h < 0.12 || sin_h > 0.3) continue;
      const double cos2 = 1.0 - sin_h * sin_h;
      const double spread = kAlpha2 * cos2 + sin_h * sin_h;
      const double density = kAlpha2 / (std::numbers::pi * spread * spread);
      const double grazing = std::pow(1.0 + glm::dot(ray, h), 5.0);
      const double fresnel = kReflectance + (1.0 - kReflectance) * grazing;
      expected += kSun * n_l * density * fresnel / (4.0 * n_l * n_v);  // Nothing masks: alpha 0.01.
      shown += double{composite.radiance.At(x, y).g};
    }
  }
  ASSERT_GT(expected, 1.0);
  EXPECT_NEAR(shown / expected, 1.0, 0.1);
}

// Against 65 samples a pixel, edges of 17 are nearer than those of 5.
TEST(CompositorOptionsTest, MoreSamplesMakeSmootherEdges) {
  const HeadlessContext context;
  CompositeScene scene(DirectionOf(215.0, 40.0));
  const Mesh box = Box({-0.5f, -0.5f, 0.2f}, {0.5f, 0.5f, 1.7f});
  const std::vector<std::vector<glm::vec3>> irradiance = {
      std::vector<glm::vec3>(box.positions_m.size(), glm::vec3(kIrradiance))};
  const auto render = [&](int samples_per_side) {
    Compositor compositor({.object_samples_per_side = samples_per_side});
    compositor.SetPhantom(scene.phantom);
    compositor.SetObjects({{box}});
    return compositor.Render(scene.Input(irradiance)).radiance;
  };
  const RgbImage finest = render(8);
  const auto error = [&](const RgbImage& picture) {
    double sum = 0.0;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      const double difference = double{picture.pixels[i].g} - double{finest.pixels[i].g};
      sum += difference * difference;
    }
    return std::sqrt(sum);
  };
  EXPECT_LT(error(render(4)), 0.85 * error(render(2)));
}

TEST(CompositorOptionsTest, NamesTheFieldThatIsWrong) {
  EXPECT_THROW(CompositorOptions{.object_samples_per_side = 1}.Validate(), std::invalid_argument);
  EXPECT_THROW(CompositorOptions{.object_samples_per_side = 3}.Validate(), std::invalid_argument);
  EXPECT_THROW(CompositorOptions{.object_samples_per_side = 10}.Validate(), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(ByBoth, RayCastLightTest, testing::ValuesIn(kByBoth), NameOfCompositeBy);

}  // namespace
}  // namespace pleinair::test::ray_cast_light_test

// SunSeenWithout and the composite's shader are one decision: the shader is held to the function.
#include "render/real_sun.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "composite_scene.h"
#include "render/gl_context.h"
#include "test_scenes.h"

namespace pleinair::test::real_sun_test {
namespace {

TEST(SunSeenWithout, IsWhatTheCompositeTakesFromAPixelInShadow) {
  const HeadlessContext context;
  Compositor compositor;
  CompositeScene scene(DirectionOf(215.0, 40.0));
  // Pixels anywhere between too dark and too bright, whatever the mesh says of them.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (std::size_t i = 0; i < scene.radiance.pixels.size(); ++i) {
    const double brightness = uniform(random) - 0.1;
    scene.radiance.pixels[i] =
        glm::vec3(scene.ModelRadiance(i, 0.0) +
                  brightness * (scene.ModelRadiance(i, 1.0) - scene.ModelRadiance(i, 0.0)));
    scene.clipped.pixels[i] = uniform(random) < 0.1 ? 1 : 0;
    scene.view.albedo_measured.pixels[i] = uniform(random) < 0.5 ? 1 : 0;
    scene.view.edge_distance_px.pixels[i] = static_cast<float>(10.0 * uniform(random));
    scene.view.sun_visibility.pixels[i] =
        uniform(random) < 0.4 ? 0.0f : static_cast<float>(uniform(random));
  }
  compositor.SetPhantom(scene.phantom);
  // A speck behind the camera; its shadow is said to be everywhere.
  compositor.SetObjects({{Sphere({30.0f, -30.0f, 1.0f}, 0.1f, 4)}});
  const std::vector<std::vector<glm::vec3>> vertex_irradiance{
      std::vector<glm::vec3>(Sphere({}, 1.0f, 4).positions_m.size(), glm::vec3(0.0f))};
  SunShares shares;
  shares.real.hidden = GrayImage(scene.view.Width(), scene.view.Height(), 1.0f);
  CompositeInput input = scene.Input(vertex_irradiance);
  input.sun_shares = &shares;
  const Composite composite = compositor.Render(input);

  const glm::dvec3 sun = scene.lighting.sun.irradiance_rgb;
  int asked = 0;
  int seen_count = 0;
  int other = 0;
  for (std::size_t i = 0; i < composite.radiance.pixels.size(); ++i) {
    if (scene.view.region.pixels[i] == SurfaceView::kNoRegion) continue;
    RealPixel pixel;
    pixel.observed = scene.radiance.pixels[i];
    pixel.clipped = scene.clipped.pixels[i] != 0;
    pixel.lit = glm::vec3(scene.ModelRadiance(i, 1.0));
    pixel.shaded = glm::vec3(scene.ModelRadiance(i, 0.0));
    pixel.model_visibility = scene.view.sun_visibility.pixels[i];
    pixel.edge_distance_px = scene.view.edge_distance_px.pixels[i];
    pixel.albedo_measured = scene.view.albedo_measured.pixels[i] != 0;
    const int width = scene.view.Width();
    const auto place = static_cast<int>(i);
    const auto seen = static_cast<double>(SunSeenWithout(
        pixel, {scene.radiance, scene.clipped, scene.view}, place % width, place / width));
    const glm::dvec3 before = scene.ModelRadiance(i, seen);
    glm::dvec3 expected(pixel.observed);
    if (pixel.clipped) expected = glm::max(expected, before);
    expected =
        glm::min(expected * scene.ModelRadiance(i, 0.0) / before, glm::dvec3(pixel.observed));
    if (seen == 0.0) expected = glm::dvec3(pixel.observed);
    ++asked;
    seen_count += seen > 0.5 ? 1 : 0;
    // Half floats; and the shader leaves out what is below 2^-11.
    const double tolerance = 2e-3 * expected.g;
    other += std::abs(static_cast<double>(composite.radiance.pixels[i].g) - expected.g) > tolerance
                 ? 1
                 : 0;
  }
  EXPECT_GT(sun.r, 0.0);
  EXPECT_GT(seen_count, asked / 4);
  EXPECT_LT(seen_count, 3 * asked / 4);
  // At the bounds of an edge, or of agreement with the mesh, rounding decides.
  EXPECT_LE(other, asked / 10000 + 1);
}

// A picture of one plane whose pixels the model takes to be lit.
class OnePlane {
 public:
  static constexpr int kSide = 21;
  static constexpr float kAlbedo = 0.3f;

  explicit OnePlane(float lit_over_shaded) : lit_over_shaded_(lit_over_shaded) {
    view.region = Image<std::int32_t>(kSide, kSide, 0);
    view.normal_world = RgbImage(kSide, kSide, {0.0f, 0.0f, 1.0f});
    view.albedo_rgb = RgbImage(kSide, kSide, glm::vec3(kAlbedo));
    camera = RgbImage(kSide, kSide, glm::vec3(lit_over_shaded));
  }
  float SunAt(int x, int y, bool measured, float edge_distance_px = 20.0f) const {
    RealPixel pixel;
    pixel.observed = camera.At(x, y);
    pixel.lit = glm::vec3(lit_over_shaded_);
    pixel.shaded = glm::vec3(1.0f);
    pixel.model_visibility = 1.0f;
    pixel.edge_distance_px = edge_distance_px;
    pixel.albedo_measured = measured;
    return SunSeenWithout(pixel, {camera, Gray8Image(), view}, x, y);
  }

  SurfaceView view;
  RgbImage camera;

 private:
  float lit_over_shaded_;
};

TEST(SunSeenWithout, FollowsTheMeshWhereTheTwoPredictionsAreOne) {
  const OnePlane plane(1.0f);
  RealPixel pixel;
  pixel.observed = pixel.lit = pixel.shaded = glm::vec3(1.0f);
  pixel.edge_distance_px = 20.0f;
  const auto seen = [&] {
    return SunSeenWithout(pixel, {plane.camera, Gray8Image(), plane.view}, 0, 20);
  };
  pixel.model_visibility = 0.75f;
  EXPECT_EQ(seen(), 0.75f);
  pixel.model_visibility = 0.0f;
  EXPECT_EQ(seen(), 0.0f);
  // In the dark.
  pixel.observed = pixel.lit = pixel.shaded = glm::vec3(0.0f);
  EXPECT_EQ(seen(), 0.0f);
}

// A real shadow that the mesh lacks has no sun to take away, even if it is hardly darker than its
// surroundings; its straight edge is where the picture has it.
TEST(SunSeenWithout, KnowsBrightRealShadowsAndTheirEdges) {
  for (const bool measured : {false, true}) {
    for (const float ratio : {measured ? 1.7f : 2.5f, 4.0f, 10.0f}) {
      OnePlane plane(ratio);
      for (int y = 0; y < OnePlane::kSide; ++y) {
        for (int x = 0; x < 10; ++x) plane.camera.At(x, y) = glm::vec3(1.0f);
      }
      for (int y = 0; y < OnePlane::kSide; ++y) {
        for (int x = 0; x < OnePlane::kSide; ++x) {
          ASSERT_EQ(plane.SunAt(x, y, measured), x < 10 ? 0.0f : 1.0f)
              << ratio << ", pixel " << x << ", " << y;
        }
      }
    }
  }
}

// A lens and the sun's disc blur a shadow's edge over four pixels. The mesh has them all in the
// sun, near one of its own edges or far from it, and albedos differ from the model's. In the edge's
// foot a side's pixels are partly lit themselves: there the share is less exact.
TEST(SunSeenWithout, FollowsASoftEdge) {
  const std::vector<float> shares = {0.0f, 0.0f, 0.15f, 0.35f, 0.65f, 0.85f, 1.0f, 1.0f};
  for (const bool is_upright : {false, true}) {
    for (const float albedo_factor : {0.9f, 1.0f, 1.1f}) {
      OnePlane plane(6.0f);
      const auto share_at = [&](int x, int y) {
        return shares[static_cast<std::size_t>(std::clamp((is_upright ? x : y) - 6, 0, 7))];
      };
      for (int y = 0; y < OnePlane::kSide; ++y) {
        for (int x = 0; x < OnePlane::kSide; ++x) {
          plane.camera.At(x, y) = glm::vec3(albedo_factor * (1.0f + 5.0f * share_at(x, y)));
        }
      }
      for (int y = 2; y < OnePlane::kSide - 2; ++y) {
        for (int x = 2; x < OnePlane::kSide - 2; ++x) {
          for (const float edge_distance_px : {0.0f, 20.0f}) {
            const bool is_middle = share_at(x, y) > 0.2f && share_at(x, y) < 0.8f;
            ASSERT_NEAR(
                plane.SunAt(x, y, true, edge_distance_px), share_at(x, y), is_middle ? 0.1f : 0.16f)
                << albedo_factor << ", pixel " << x << ", " << y;
          }
        }
      }
    }
  }
}

// Joints, pebbles and broken pixels are narrower than shadows.
TEST(SunSeenWithout, TakesNoNarrowDarkMarkForAShadow) {
  OnePlane plane(5.0f);
  for (int i = 0; i < OnePlane::kSide; ++i) {
    plane.camera.At(i, 5) = glm::vec3(0.8f);
    plane.camera.At(13, i) = glm::vec3(1.0f);
  }
  plane.camera.At(4, 15) = glm::vec3(std::nanf(""));
  plane.camera.At(4, 12) = glm::vec3(0.0f);
  for (int y = 0; y < OnePlane::kSide; ++y) {
    for (int x = 0; x < OnePlane::kSide; ++x) {
      if (x == 4 && y == 15) continue;
      ASSERT_EQ(plane.SunAt(x, y, true), 1.0f) << "pixel " << x << ", " << y;
    }
  }
  // A dark mark that the survey has measured is none.
  OnePlane marked(5.0f);
  for (int y = 4; y < 14; ++y) {
    for (int x = 4; x < 14; ++x) {
      marked.camera.At(x, y) *= 0.2f;
      marked.view.albedo_rgb.At(x, y) *= 0.2f;
    }
  }
  EXPECT_EQ(marked.SunAt(2, 8, true), 1.0f);
}

// A light that the picture contradicts puts a surface between sun and shade. A new shadow
// there has no steps: what is left changes a few times as much as the surface, and lies about
// shade.
TEST(SunSeenWithout, LeavesNoSpecksWhereTheLightIsWrong) {
  constexpr float kRatio = 10.0f;
  OnePlane plane(kRatio);
  const auto left_of = [&](float radiance) {
    plane.camera = RgbImage(OnePlane::kSide, OnePlane::kSide, glm::vec3(radiance));
    return radiance / (1.0f + plane.SunAt(10, 10, true) * (kRatio - 1.0f));
  };
  constexpr float kStep = 1.02f;
  float before = left_of(1.0f);
  for (float radiance = kStep; radiance < kRatio; radiance *= kStep) {
    const float left = left_of(radiance);
    ASSERT_LT(std::abs(std::log(left / before)), 1.05f * std::log(kStep)) << radiance;
    ASSERT_GT(std::log(left), -1.5f * kSurelySigmas * kSharedLogSigmaMeasured) << radiance;
    ASSERT_LT(std::log(left), 1.5f * kSurelySigmas * kSharedLogSigmaMeasured) << radiance;
    before = left;
  }
}

}  // namespace
}  // namespace pleinair::test::real_sun_test

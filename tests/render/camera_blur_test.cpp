// Objects and their shadows as soft as the camera's picture.
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "calib/edge_blur.h"
#include "composite_scene.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "render/internal/blur_kernel.h"
#include "test_scenes.h"

namespace pleinair::test::camera_blur_test {
namespace {

// Upright edges would all lie at the same place in their pixels, and a blur from pixel to pixel
// leaves an edge between two of them by a sixth of a pixel's square narrower than the mean.
Mesh LeaningBox(float angle_rad = 0.25f) {
  Mesh box = Box({-0.5f, -0.5f, -0.55f}, {0.5f, 0.5f, 0.55f});
  const glm::mat4 leaning = glm::rotate(
      glm::translate(glm::mat4(1.0f), {0.0f, 0.0f, 1.15f}), angle_rad, {0.6f, -0.8f, 0.0f});
  for (glm::vec3& p : box.positions_m) p = glm::vec3(leaning * glm::vec4(p, 1.0f));
  for (glm::vec3& n : box.normals) n = glm::mat3(leaning) * n;
  return box;
}

class CameraBlur : public testing::TestWithParam<CompositeBy> {
 protected:
  CameraBlur() {
    compositor_.SetPhantom(scene_.phantom);
    compositor_.SetObjects({{box_}});
    std::fill(scene_.radiance.pixels.begin(), scene_.radiance.pixels.end(), glm::vec3(2.0f));
    scene_.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
  }

  Composite Render(float blur_px, const SunShares* shares = nullptr) {
    const std::vector<std::vector<glm::vec3>> irradiance{
        std::vector<glm::vec3>(box_.positions_m.size(), glm::vec3(90.0f))};
    CompositeInput input = scene_.Input(irradiance);
    input.camera_blur_px = blur_px;
    input.sun_shares = shares;
    return compositor_.Render(input);
  }

  // The object's outline as the model's only edge.
  SurfaceView OutlineOf(const Composite& sharp) const {
    SurfaceView view = scene_.view;
    const int width = view.Width();
    const int height = view.Height();
    view.normal_world = RgbImage(width, height, {0.0f, 0.0f, 1.0f});
    view.position_world_m = RgbImage(width, height);
    view.sun_visibility = GrayImage(width, height, 1.0f);
    for (std::size_t i = 0; i < sharp.change.pixels.size(); ++i) {
      view.region.pixels[i] = sharp.change.pixels[i] == 0 ? 0 : 1;
    }
    return view;
  }

  HeadlessContext context_;
  Compositor compositor_{CompositorOptions{.composite_by = GetParam()}};
  CompositeScene scene_{DirectionOf(215.0, 40.0)};
  const Mesh box_ = LeaningBox();
};

EdgeBlur BlurOf(const RgbImage& picture, const Gray8Image& clipped, const SurfaceView& view) {
  EdgeBlurMeter meter;
  meter.Add(picture, clipped, view);
  return meter.Blur();
}

// Standard deviation of an edge, with the pixel's own square.
double WidthPx(double blur_px) { return std::sqrt(blur_px * blur_px + 1.0 / 12.0); }

TEST_P(CameraBlur, EdgesAreAsWideAsAskedFor) {
  for (const float blur_px : {0.0f, 0.3f, 0.6f, 1.0f, 1.8f}) {
    EdgeBlurMeter meter;
    for (const float angle_rad : {0.15f, 0.25f, 0.4f}) {
      compositor_.SetObjects({{LeaningBox(angle_rad)}});
      const SurfaceView outline = OutlineOf(Render(0.0f));
      meter.Add(Render(blur_px).radiance, {}, outline);
    }
    const EdgeBlur measured = meter.Blur();
    if (blur_px == 0.0f) {
      EXPECT_EQ(measured.sigma_px, 0.0);
      continue;
    }
    EXPECT_GE(measured.edges, 60);
    // The kernel is of least error over edges wherever they lie in a pixel, the meter of most
    // likelihood: below half a pixel the one is the wider.
    EXPECT_NEAR(WidthPx(measured.sigma_px) / WidthPx(blur_px), 1.0, blur_px < 0.5f ? 0.15 : 0.1)
        << blur_px;
  }
}

TEST_P(CameraBlur, StaysNearTheObjectAndTakesNoLightAway) {
  const Composite sharp = Render(0.0f);
  const Composite soft = Render(1.0f);
  double sharp_sum = 0.0;
  double soft_sum = 0.0;
  for (int y = 0; y < soft.radiance.height; ++y) {
    for (int x = 0; x < soft.radiance.width; ++x) {
      sharp_sum += double{sharp.radiance.At(x, y).g};
      soft_sum += double{soft.radiance.At(x, y).g};
      bool is_near = false;
      for (int dy = -4; dy <= 4; ++dy) {
        for (int dx = -4; dx <= 4; ++dx) {
          is_near |= sharp.change.Contains(x + dx, y + dy) && sharp.change.At(x + dx, y + dy) != 0;
        }
      }
      if (is_near) continue;
      ASSERT_EQ(soft.change.At(x, y), 0);
      ASSERT_EQ(soft.radiance.At(x, y), scene_.radiance.At(x, y));
    }
  }
  // Half floats of the layer, and what is cut off below 1/512.
  EXPECT_NEAR(soft_sum / sharp_sum, 1.0, 1e-3);
}

TEST_P(CameraBlur, GoesThroughALensWithDistortion) {
  CameraIntrinsics bent = scene_.Camera().intrinsics;
  bent.distortion = {-0.15, 0.02, 0.0, 0.0, 0.0};
  scene_.SetIntrinsics(bent);
  std::fill(scene_.radiance.pixels.begin(), scene_.radiance.pixels.end(), glm::vec3(2.0f));
  const SurfaceView outline = OutlineOf(Render(0.0f));
  const EdgeBlur measured = BlurOf(Render(1.2f).radiance, {}, outline);
  EXPECT_NEAR(measured.sigma_px, 1.2, 0.1 * 1.2);
}

// How far a shadow's edge along a column is smeared, on the rows of even, sunlit ground: mean and
// variance of where the light goes.
TEST_P(CameraBlur, EdgesOfShadowsAreAsWideAsAskedFor) {
  scene_ = CompositeScene(DirectionOf(215.0, 40.0));
  constexpr int kEdge = 40;
  SunShares shares{{0, 0, GrayImage(scene_.view.Width(), scene_.view.Height(), 0.0f)}, {}};
  for (int y = 0; y < scene_.view.Height(); ++y) {
    for (int x = 0; x < kEdge; ++x) shares.real.hidden.At(x, y) = 1.0f;
  }
  for (const float blur_px : {0.3f, 1.0f}) {
    const Composite composite = Render(blur_px, &shares);
    const double variance = BlurKernel(blur_px).Variance();
    int rows = 0;
    for (int y = 0; y < scene_.view.Height(); ++y) {
      double moved = 0.0;
      double squares = 0.0;
      double before = 1.0;
      bool is_even = true;
      for (int x = kEdge - 8; x < kEdge + 8; ++x) {
        const std::size_t i = scene_.view.region.Index(x, y);
        const double lit = scene_.ModelRadiance(i, 1.0).g;
        const double shaded = scene_.ModelRadiance(i, 0.0).g;
        is_even = is_even && scene_.view.sun_visibility.pixels[i] == 1.0f && shaded < 0.9 * lit &&
                  composite.change.pixels[i] != static_cast<std::uint8_t>(PixelChange::kCovered) &&
                  scene_.view.region.pixels[i] == scene_.view.region.At(kEdge, y);
        if (!is_even) break;
        const double hidden = (lit - double{composite.radiance.pixels[i].g}) / (lit - shaded);
        const double at = x - kEdge;
        moved += (before - hidden) * at;
        squares += (before - hidden) * at * at;
        before = hidden;
      }
      if (!is_even) continue;
      ++rows;
      // Half floats of light that the shadow takes a part of.
      EXPECT_NEAR(moved, 0.0, 0.02) << "row " << y;
      EXPECT_NEAR(squares - moved * moved, variance, 0.05 * blur_px + 0.01) << "row " << y;
    }
    EXPECT_GT(rows, 10);
  }
}

// Shadow on what an object covers is not smeared onto the lit ground beside it.
TEST_P(CameraBlur, CoveredShadowsDoNotShowBesideTheObject) {
  scene_ = CompositeScene(DirectionOf(215.0, 40.0));
  const Composite sharp = Render(0.0f);
  SunShares shares{{0, 0, GrayImage(scene_.view.Width(), scene_.view.Height(), 0.0f)}, {}};
  const auto is_covered = [&sharp](int x, int y) {
    return sharp.change.At(x, y) == static_cast<std::uint8_t>(PixelChange::kCovered);
  };
  int hidden = 0;
  for (int y = 1; y + 1 < scene_.view.Height(); ++y) {
    for (int x = 1; x + 1 < scene_.view.Width(); ++x) {
      if (!is_covered(x, y) || !is_covered(x - 1, y) || !is_covered(x + 1, y) ||
          !is_covered(x, y - 1) || !is_covered(x, y + 1)) {
        continue;
      }
      shares.real.hidden.At(x, y) = 1.0f;
      ++hidden;
    }
  }
  ASSERT_GT(hidden, 100);
  const Composite soft = Render(0.5f, &shares);
  for (int y = 0; y < scene_.view.Height(); ++y) {
    for (int x = 0; x < scene_.view.Width(); ++x) {
      if (soft.change.At(x, y) == static_cast<std::uint8_t>(PixelChange::kCovered)) continue;
      // What shines past the blurred object's rim; smeared over all it would be 5 %.
      if (scene_.radiance.At(x, y).g == 0.0f) continue;
      EXPECT_NEAR(soft.radiance.At(x, y).g / scene_.radiance.At(x, y).g, 1.0f, 0.005f)
          << x << ", " << y;
    }
  }
}

TEST_P(CameraBlur, FramesDoNotRememberOtherBlurs) {
  const Composite first = Render(0.7f);
  Render(2.5f);
  EXPECT_EQ(Render(0.7f).radiance.pixels, first.radiance.pixels);
}

TEST_P(CameraBlur, RefusesWhatMakesNoSense) {
  for (const float blur_px : {-1.0f, 9.0f, NAN}) {
    EXPECT_THROW(Render(blur_px), std::invalid_argument) << blur_px;
  }
}

INSTANTIATE_TEST_SUITE_P(ByBoth, CameraBlur, testing::ValuesIn(kByBoth), NameOfCompositeBy);

}  // namespace
}  // namespace pleinair::test::camera_blur_test

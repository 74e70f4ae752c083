// Objects as soft as the camera's picture, read off the composite as a camera's own blur would be.
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "calib/edge_blur.h"
#include "composite_scene.h"
#include "render/compositor.h"
#include "render/gl_context.h"
#include "test_scenes.h"

namespace pleinair::test::object_blur_test {
namespace {

class ObjectBlur : public testing::TestWithParam<CompositeBy> {
 protected:
  ObjectBlur() {
    compositor_.SetPhantom(scene_.phantom);
    compositor_.SetObjects({{box_}});
    std::fill(scene_.radiance.pixels.begin(), scene_.radiance.pixels.end(), glm::vec3(2.0f));
    scene_.lighting.sun.irradiance_rgb = glm::dvec3(0.0);
  }

  Composite Render(float blur_px) {
    const std::vector<std::vector<glm::vec3>> irradiance{
        std::vector<glm::vec3>(box_.positions_m.size(), glm::vec3(90.0f))};
    CompositeInput input = scene_.Input(irradiance);
    input.object_blur_px = blur_px;
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
  const Mesh box_ = Box({-0.5f, -0.5f, 0.6f}, {0.5f, 0.5f, 1.7f});
};

// Standard deviation of an edge, with the pixel's own square.
double WidthPx(double blur_px) { return std::sqrt(blur_px * blur_px + 1.0 / 12.0); }

// The layer is blurred pixel by pixel: below a pixel an edge's width hangs on where it lies in one,
// and the narrowest are told.
TEST_P(ObjectBlur, EdgesAreAsWideAsAskedFor) {
  const Composite sharp = Render(0.0f);
  const SurfaceView outline = OutlineOf(sharp);
  EXPECT_EQ(MeasureEdgeBlur(sharp.radiance, {}, outline).sigma_px, 0.0);
  for (const float blur_px : {0.6f, 1.0f, 1.8f}) {
    const EdgeBlur measured = MeasureEdgeBlur(Render(blur_px).radiance, {}, outline);
    EXPECT_GE(measured.edges, 20);
    EXPECT_NEAR(WidthPx(measured.sigma_px) / WidthPx(blur_px), 1.0, blur_px < 1.0f ? 0.2 : 0.1);
  }
}

TEST_P(ObjectBlur, StaysNearTheObjectAndTakesNoLightAway) {
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

TEST_P(ObjectBlur, GoesThroughALensWithDistortion) {
  CameraIntrinsics bent = scene_.Camera().intrinsics;
  bent.distortion = {-0.15, 0.02, 0.0, 0.0, 0.0};
  scene_.SetIntrinsics(bent);
  std::fill(scene_.radiance.pixels.begin(), scene_.radiance.pixels.end(), glm::vec3(2.0f));
  const SurfaceView outline = OutlineOf(Render(0.0f));
  const EdgeBlur measured = MeasureEdgeBlur(Render(1.2f).radiance, {}, outline);
  // The layer is looked up between pixels, which softens by up to a quarter of a pixel's square.
  EXPECT_NEAR(measured.sigma_px, 1.2, 0.2 * 1.2);
}

TEST_P(ObjectBlur, FramesDoNotRememberOtherBlurs) {
  const Composite first = Render(0.7f);
  Render(2.5f);
  EXPECT_EQ(Render(0.7f).radiance.pixels, first.radiance.pixels);
}

TEST_P(ObjectBlur, RefusesWhatMakesNoSense) {
  for (const float blur_px : {-1.0f, 9.0f, NAN}) {
    EXPECT_THROW(Render(blur_px), std::invalid_argument) << blur_px;
  }
}

INSTANTIATE_TEST_SUITE_P(ByBoth, ObjectBlur, testing::ValuesIn(kByBoth), NameOfCompositeBy);

}  // namespace
}  // namespace pleinair::test::object_blur_test

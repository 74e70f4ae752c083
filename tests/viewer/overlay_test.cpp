// Overlays of a view that is put together by hand.
#include "apps/viewer/overlay.h"

#include <limits>
#include <set>
#include <string>

#include <gmock/gmock.h>

namespace pleinair::overlay_test {
namespace {

constexpr int kWidth = 4;
constexpr int kHeight = 3;

constexpr glm::vec3 kUp{0.0f, 0.0f, 1.0f};
constexpr glm::vec3 kSouth{0.0f, -1.0f, 0.0f};

// Ground, but for the sky in the upper left corner. A sun in the south, 45 degrees high.
class Overlay : public testing::Test {
 protected:
  Overlay() {
    view_.region_names = {"ground", "wall"};
    view_.region = Image<std::int32_t>(kWidth, kHeight, 0);
    view_.region.At(0, 0) = SurfaceView::kNoRegion;
    view_.normal_world = Image<glm::vec3>(kWidth, kHeight, kUp);
    view_.albedo_rgb = Image<glm::vec3>(kWidth, kHeight, glm::vec3(0.0f, 0.5f, 1.0f));
    view_.may_be_sampled = Image<std::uint8_t>(kWidth, kHeight, 1);
    view_.sky_response = {Image<glm::vec3>(kWidth, kHeight, glm::vec3(1.0f))};
    view_.sun_visibility = Image<float>(kWidth, kHeight, 1.0f);
    view_.sun_direction_enu = glm::normalize(glm::dvec3(0.0, -1.0, 1.0));
    frame_.unusable = Gray8Image(kWidth, kHeight, 0);
    // A sun alone, of 2 in each channel.
    result_.raw_lighting.sun.irradiance_rgb = glm::dvec3(2.0);
  }

  // At `pixel`; the model gives it 1.
  void AddSample(glm::ivec2 pixel, double radiance) {
    DiffuseSample sample;
    sample.pixel = pixel;
    sample.sun_transport_rgb = glm::dvec3(0.5);
    sample.radiance_rgb = glm::dvec3(radiance);
    samples_.push_back(sample);
  }

  Rgba8Image Draw(DrawOverlay draw) const { return draw({frame_, result_, view_, samples_}); }

  Frame frame_;
  FrameResult result_;
  SurfaceView view_;
  std::vector<DiffuseSample> samples_;
};

TEST_F(Overlay, HasTheViewsSizeAndANameOfItsOwn) {
  std::set<std::string> names;
  for (const OverlayDefinition& overlay : Overlays()) {
    SCOPED_TRACE(overlay.name);
    EXPECT_TRUE(names.insert(overlay.name).second);
    const Rgba8Image picture = Draw(overlay.draw);
    EXPECT_EQ(picture.width, kWidth);
    EXPECT_EQ(picture.height, kHeight);
    EXPECT_EQ(picture.At(0, 0), kNoColour);  // The sky, without a sample or a fault.
  }
  EXPECT_EQ(names.size(), 8u);  // Keys Alt+1 to Alt+8.
}

TEST_F(Overlay, NormalsAreRedEastGreenNorthBlueUp) {
  view_.normal_world.At(1, 0) = kSouth;
  view_.normal_world.At(2, 0) = {1.0f, 0.0f, 0.0f};
  const Rgba8Image picture = Draw(DrawNormals);
  EXPECT_EQ(picture.At(3, 2), glm::u8vec4(128, 128, 255, 255));
  EXPECT_EQ(picture.At(1, 0), glm::u8vec4(128, 0, 128, 255));
  EXPECT_EQ(picture.At(2, 0), glm::u8vec4(255, 128, 128, 255));
}

// IEC 61966-2-1: 0.5 has the code 188 (187.5).
TEST_F(Overlay, AlbedoIsShownAsADisplayShowsIt) {
  EXPECT_EQ(Draw(DrawAlbedo).At(1, 1), glm::u8vec4(0, 188, 255, 255));
}

TEST_F(Overlay, AmbientWeightGoesFromBlueToYellow) {
  view_.sky_response[0].At(1, 1) = glm::vec3(0.0f);
  view_.sky_response[0].At(2, 1) = {0.0f, 0.5f, 1.0f};  // The mean of its channels counts.
  const Rgba8Image picture = Draw(DrawAmbientWeight);
  EXPECT_EQ(picture.At(1, 1), ColourOfShare(0.0f));
  EXPECT_EQ(picture.At(2, 1), ColourOfShare(0.5f));
  EXPECT_EQ(picture.At(3, 1), ColourOfShare(1.0f));
  // Lightness rises evenly: of the sum of all channels, at least.
  int before = -1;
  for (int i = 0; i <= 20; ++i) {
    const glm::u8vec4 colour = ColourOfShare(static_cast<float>(i) / 20.0f);
    const int lightness = colour.r + colour.g + colour.b;
    EXPECT_GT(lightness, before) << i;
    before = lightness;
  }
}

TEST_F(Overlay, SunVisibilityIsBlackInShadeAndWhereASurfaceFacesAway) {
  view_.sun_visibility.At(1, 1) = 0.0f;
  view_.sun_visibility.At(2, 1) = 0.5f;
  view_.normal_world.At(3, 1) = {0.0f, 1.0f, 0.0f};  // North, and visible by what was cast.
  const Rgba8Image picture = Draw(DrawSunVisibility);
  EXPECT_EQ(picture.At(0, 1), glm::u8vec4(255, 220, 60, 255));
  EXPECT_EQ(picture.At(1, 1), glm::u8vec4(0, 0, 0, 255));
  EXPECT_EQ(picture.At(2, 1), glm::u8vec4(128, 110, 30, 255));
  EXPECT_EQ(picture.At(3, 1), glm::u8vec4(0, 0, 0, 255));
}

TEST_F(Overlay, ClippingShowsEachFlagInItsOwnColour) {
  frame_.unusable.At(0, 1) = kClipped[1] | kUnusable;
  frame_.unusable.At(1, 1) = kNearBlack;
  frame_.unusable.At(2, 1) = kUnusable;
  frame_.clipped = Gray8Image(kWidth, kHeight, 0);
  frame_.clipped.At(3, 1) = 1;
  const Rgba8Image picture = Draw(DrawClipping);
  const glm::u8vec4 clipped = picture.At(0, 1);
  EXPECT_GT(clipped.r, 2 * std::max(clipped.g, clipped.b));
  EXPECT_EQ(picture.At(3, 1), clipped);
  const glm::u8vec4 dark = picture.At(1, 1);
  EXPECT_GT(dark.b, 2 * std::max(dark.r, dark.g));
  const glm::u8vec4 masked = picture.At(2, 1);
  EXPECT_EQ(masked.r, masked.b);
  EXPECT_GT(masked.a, 0);
  EXPECT_EQ(picture.At(0, 2), kNoColour);
}

TEST_F(Overlay, RegionsAreBrightWhereSamplesMayBeDrawn) {
  view_.region.At(1, 1) = 1;
  view_.may_be_sampled.At(2, 1) = 0;
  const Rgba8Image picture = Draw(DrawRegions);
  const glm::u8vec4 ground = picture.At(0, 1);
  EXPECT_EQ(ground, picture.At(0, 2));
  EXPECT_NE(ground, picture.At(1, 1));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(picture.At(2, 1)[c], ground[c] * 70.0 / 255.0, 1.0);
}

TEST_F(Overlay, SampleResidualsAreBlueBelowAndRedAboveTheModel) {
  view_ = {};
  view_.region = Image<std::int32_t>(40, 8, 0);
  AddSample({4, 4}, 0.5);
  AddSample({14, 4}, 1.0);
  AddSample({24, 4}, 1.3);
  AddSample({39, 7}, 9.0);  // Its mark is cut off by the picture's corner.
  const Rgba8Image picture = Draw(DrawSampleResiduals);
  EXPECT_EQ(picture.At(4, 4), ColourOfDifference(-1.0f));
  EXPECT_GT(picture.At(4, 4).b, 2 * picture.At(4, 4).r);
  EXPECT_EQ(picture.At(14, 4), glm::u8vec4(250, 250, 250, 255));
  EXPECT_NEAR(picture.At(24, 4).r, ColourOfDifference(1.0f).r, 1);
  EXPECT_GT(picture.At(39, 7).r, 2 * picture.At(39, 7).b);
  EXPECT_EQ(picture.At(9, 4), kNoColour);
}

TEST_F(Overlay, ResidualsLeaveClippedChannelsOut) {
  DiffuseSample sample;
  sample.sun_transport_rgb = glm::dvec3(0.5);
  sample.radiance_rgb = {1.2, 100.0, 1.0};
  sample.radiance_stddev_rgb.y = std::numeric_limits<double>::infinity();
  EXPECT_NEAR(RelativeResidual(sample, result_.raw_lighting), 0.1, 1e-12);
}

TEST_F(Overlay, SampleKindsAreLitShadedAndOutliers) {
  view_.region = Image<std::int32_t>(40, 8, 0);
  view_.normal_world = Image<glm::vec3>(40, 8, kUp);
  view_.sun_visibility = Image<float>(40, 8, 1.0f);
  view_.sun_visibility.At(14, 4) = 0.0f;
  AddSample({4, 4}, 1.0);
  AddSample({14, 4}, 1.0);
  AddSample({24, 4}, 1.0);
  samples_.back().is_rejected = true;
  AddSample({34, 4}, 1.5);  // Far off, but the fit took it.
  const Rgba8Image picture = Draw(DrawSampleKinds);
  const glm::u8vec4 lit = picture.At(4, 4);
  EXPECT_GT(lit.r, 2 * lit.b);  // Yellow.
  EXPECT_GT(lit.g, 2 * lit.b);
  EXPECT_GT(picture.At(14, 4).b, 2 * picture.At(14, 4).r);
  EXPECT_GT(picture.At(24, 4).r, 2 * picture.At(24, 4).g);
  EXPECT_EQ(picture.At(34, 4), lit);
}

}  // namespace
}  // namespace pleinair::overlay_test

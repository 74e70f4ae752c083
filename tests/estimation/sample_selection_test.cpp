#include "estimation/sample_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/estimation/synthetic_view.h"

namespace pleinair::sample_selection_test {
namespace {

using testing::MakeFrame;
using testing::MakeView;
using testing::SyntheticPicture;

std::vector<DiffuseSample> DrawAndMeasure(const SurfaceView& view,
                                          const Frame& frame,
                                          const SampleSelectionOptions& options = {}) {
  SampleSet set;
  set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, options);
  std::vector<DiffuseSample> samples;
  set.Measure(view.sun_direction_enu, frame.radiance, frame.unusable, samples);
  return samples;
}

TEST(SampleSelection, MeasuresWhatTheModelPredicts) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  const std::vector<DiffuseSample> samples = DrawAndMeasure(view, frame);
  ASSERT_EQ(samples.size(), 500u);
  for (const DiffuseSample& sample : samples) {
    const glm::dvec3 predicted =
        picture.sun * sample.sun_transport_rgb + picture.sky * sample.sky_transport_rgb[0];
    for (int c = 0; c < 3; ++c) {
      // Albedo varies within the footprint: only means of the product agree. Float pixels: 1e-6.
      EXPECT_NEAR(sample.radiance_rgb[c], predicted[c], 2e-6 * predicted[c]);
    }
  }
}

TEST(SampleSelection, GivesEveryStratumAnEqualShare) {
  SyntheticPicture picture;
  picture.shadow_share = 0.3;
  const SurfaceView view = MakeView(picture);
  std::map<std::pair<int, bool>, int> count;
  for (const DiffuseSample& sample : DrawAndMeasure(view, MakeFrame(picture, view))) {
    // In the sun, the beam's response is of the sky's size; in shade there is at most a bounce.
    const bool lit = sample.sun_transport_rgb.y > 0.3 * sample.sky_transport_rgb[0].y;
    ++count[{sample.plane, lit}];
  }
  ASSERT_EQ(count.size(), 4u);  // Wall and ground, lit and shaded.
  for (const auto& [stratum, samples] : count) {
    EXPECT_EQ(samples, 125) << "plane " << stratum.first << (stratum.second ? " lit" : " shaded");
  }
}

// A shaded strip of three tenths: its share of the samples is that of its area, less the edges.
TEST(SampleSelection, ProportionalSharesAreThoseOfTheArea) {
  SyntheticPicture picture;
  picture.shadow_share = 0.3;
  const SurfaceView view = MakeView(picture);
  std::set<std::pair<int, int>> dithered;
  for (const SampleChoice choice : {SampleChoice::kProportional, SampleChoice::kRandom}) {
    const std::vector<DiffuseSample> samples =
        DrawAndMeasure(view, MakeFrame(picture, view), {500, 1, choice});
    ASSERT_EQ(samples.size(), 500u);
    int lit = 0;
    int repeated = 0;
    for (const DiffuseSample& sample : samples) {
      lit += sample.sun_transport_rgb.y > 0.3 * sample.sky_transport_rgb[0].y ? 1 : 0;
      if (choice == SampleChoice::kProportional) {
        dithered.insert({sample.pixel.x, sample.pixel.y});
      } else {
        repeated += dithered.contains({sample.pixel.x, sample.pixel.y}) ? 1 : 0;
      }
    }
    EXPECT_NEAR(lit, 0.7 * 500, 0.05 * 500);
    EXPECT_LT(repeated, 100) << "other pixels";
  }
}

TEST(SampleSelection, HandsOnWhatASmallStratumCannotUse) {
  SyntheticPicture picture;
  picture.shadow_share = 0.08;  // Some 12 columns, of which the edges take most.
  const SurfaceView view = MakeView(picture);
  const std::vector<DiffuseSample> samples =
      DrawAndMeasure(view, MakeFrame(picture, view), {2000, 1});
  EXPECT_EQ(samples.size(), 2000u);
  int shaded = 0;
  for (const DiffuseSample& sample : samples) shaded += sample.pixel.x < 12 ? 1 : 0;
  EXPECT_GT(shaded, 100);
  EXPECT_LT(shaded, 600);
}

TEST(SampleSelection, KeepsEveryFootprintClearOfEdgesAndUnusablePixels) {
  SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  for (int y = 0; y < picture.height; ++y) {
    frame.unusable.At(100, y) = 1;
    frame.radiance.At(20, y) = glm::vec3(std::numeric_limits<float>::quiet_NaN());
    frame.radiance.At(40, y).y = std::numeric_limits<float>::infinity();
  }
  const std::vector<DiffuseSample> samples = DrawAndMeasure(view, frame);
  EXPECT_EQ(samples.size(), 500u);
  // Radius 2, being 1.2 rounded up; its corner is 2.8 away, and 1.5 are for pose and mesh.
  for (const DiffuseSample& sample : samples) {
    EXPECT_GT(view.edge_distance_px.At(sample.pixel.x, sample.pixel.y), 4.3f);
    for (const int column : {20, 40, 100}) EXPECT_GT(std::abs(sample.pixel.x - column), 2);
  }
}

TEST(SampleSelection, SpreadsTheSamplesOverThePicture) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  const std::vector<DiffuseSample> samples =
      DrawAndMeasure(view, MakeFrame(picture, view), {400, 1});
  // 100 footprints in each quarter of 70 x 50 usable pixels; every 20 x 20 block of them has some
  // (11 expected, random ones would leave 1 in 60000 blocks empty).
  std::map<std::pair<int, int>, int> blocks;
  for (const DiffuseSample& sample : samples) ++blocks[{sample.pixel.x / 20, sample.pixel.y / 20}];
  for (int by = 0; by < 6; ++by) {
    for (int bx = 0; bx < 8; ++bx) EXPECT_GT((blocks[{bx, by}]), 2) << bx << " " << by;
  }
}

TEST(SampleSelection, IsAPureFunctionOfItsArguments) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  const auto pixels = [&](std::uint64_t seed) {
    std::vector<std::pair<int, int>> result;
    for (const DiffuseSample& sample : DrawAndMeasure(view, frame, {500, seed})) {
      result.emplace_back(sample.pixel.y, sample.pixel.x);
    }
    return result;
  };
  EXPECT_EQ(pixels(1), pixels(1));
  EXPECT_NE(pixels(1), pixels(2));
  const auto other = pixels(3);
  EXPECT_TRUE(std::is_sorted(other.begin(), other.end()));
}

TEST(SampleSelection, LeavesOutWhatGrazesTheSunAndHalfShadows) {
  SyntheticPicture picture;
  SurfaceView view = MakeView(picture);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (y < picture.height / 2) {
        view.normal_world.At(x, y) = glm::vec3(-0.6691f, 0.7431f, 0.0f);  // n.l = -0.02.
        if (x >= picture.width / 2) view.normal_world.At(x, y) = {-0.7431f, 0.6691f, 0.0f};
      } else if (x >= picture.width / 2) {
        view.sun_visibility.At(x, y) = 0.5f;
      }
    }
  }
  for (const DiffuseSample& sample : DrawAndMeasure(view, MakeFrame(picture, view))) {
    EXPECT_LT(sample.pixel.x, picture.width / 2);
  }
}

// Flat ground under a low sun: all of it grazes, whole or as it rises. With a wall beside it,
// the next draw leaves the ground out.
TEST(SampleSelection, TakesWhatGrazesTheSunWhereThereIsNothingElse) {
  const SyntheticPicture picture;
  for (const float visibility : {1.0f, 0.5f}) {
    SurfaceView view = MakeView(picture);
    const glm::vec3 to_sun(view.sun_direction_enu);
    const glm::vec3 across = glm::normalize(glm::cross(to_sun, glm::vec3(0.3f, 0.5f, 0.8f)));
    const glm::vec3 grazing = glm::normalize(across + 0.05f * to_sun);
    for (std::size_t i = 0; i < view.normal_world.pixels.size(); ++i) {
      view.normal_world.pixels[i] = grazing;
      view.sun_visibility.pixels[i] = visibility;
    }
    const Frame frame = MakeFrame(picture, view);
    const std::vector<DiffuseSample> samples = DrawAndMeasure(view, frame);
    ASSERT_EQ(samples.size(), 500u) << visibility;
    for (const DiffuseSample& sample : samples) {
      const glm::dvec3 predicted =
          picture.sun * sample.sun_transport_rgb + picture.sky * sample.sky_transport_rgb[0];
      EXPECT_NEAR(sample.radiance_rgb.g, predicted.g, 1e-5 * predicted.g);
    }
    SampleSet set;
    set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width / 2; ++x) {
        view.normal_world.At(x, y) = to_sun;
        view.sun_visibility.At(x, y) = 1.0f;
      }
    }
    set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
    std::vector<DiffuseSample> beside;
    set.Measure(view.sun_direction_enu, frame.radiance, frame.unusable, beside);
    ASSERT_FALSE(beside.empty());
    for (const DiffuseSample& sample : beside) EXPECT_LT(sample.pixel.x, picture.width / 2);
  }
}

TEST(SampleSelection, LeavesOutWindowsAndWhatElseIsNotOfItsRegion) {
  SyntheticPicture picture;
  SurfaceView view = MakeView(picture);
  const auto is_window = [](int x, int y) { return y < 60 && x % 20 < 8; };
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (is_window(x, y)) view.albedo_rgb.At(x, y) = {0.08f, 0.09f, 0.1f};
    }
  }
  const std::vector<DiffuseSample> samples = DrawAndMeasure(view, MakeFrame(picture, view));
  EXPECT_GT(samples.size(), 400u);
  for (const DiffuseSample& sample : samples) {
    EXPECT_FALSE(is_window(sample.pixel.x, sample.pixel.y));
  }
}

TEST(SampleSelection, TakesFilledAlbedosOnlyAfterMeasuredOnes) {
  SyntheticPicture picture;
  SurfaceView view = MakeView(picture);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; x += 2) view.albedo_measured.At(x, y) = 0;
  }
  for (const DiffuseSample& sample : DrawAndMeasure(view, MakeFrame(picture, view))) {
    EXPECT_EQ(sample.pixel.x % 2, 1);
    EXPECT_EQ(sample.weight, 1.0);
  }
  // Where none is measured they count in full: there is nothing to prefer.
  std::fill(view.albedo_measured.pixels.begin(), view.albedo_measured.pixels.end(), 0);
  for (const DiffuseSample& sample : DrawAndMeasure(view, MakeFrame(picture, view))) {
    EXPECT_EQ(sample.weight, 1.0);
  }
}

TEST(SampleSelection, LeavesOutFootprintsThatBecomeUnusableLater) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  SampleSet set;
  set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
  std::vector<DiffuseSample> samples;
  EXPECT_EQ(set.Measure(view.sun_direction_enu, frame.radiance, frame.unusable, samples), 0);
  const glm::ivec2 hit = samples[10].pixel;
  frame.unusable.At(hit.x + 1, hit.y - 1) = 1;
  const int left_out = set.Measure(view.sun_direction_enu, frame.radiance, frame.unusable, samples);
  EXPECT_GE(left_out, 1);
  EXPECT_EQ(static_cast<int>(samples.size()), set.Size() - left_out);
  for (const DiffuseSample& sample : samples) EXPECT_NE(sample.pixel, hit);
}

// What is not clipped of a wall that is, panes and shadows, is no better place to measure it.
TEST(SampleSelection, MarksClippedChannelsAndLooksForNoOtherPlaces) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  Frame frame = MakeFrame(picture, view);
  SampleSet set;
  set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
  std::vector<DiffuseSample> sound;
  set.Measure(view.sun_direction_enu, frame.radiance, frame.unusable, sound);
  const glm::ivec2 hit = sound[10].pixel;
  frame.unusable.At(hit.x + 1, hit.y - 1) = kClipped[2];
  std::vector<DiffuseSample> samples = DrawAndMeasure(view, frame);
  ASSERT_EQ(samples.size(), sound.size());
  int marked = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].pixel, sound[i].pixel);
    EXPECT_EQ(samples[i].radiance_stddev_rgb.x, 0.0);
    marked += std::isinf(samples[i].radiance_stddev_rgb.z) ? 1 : 0;
  }
  EXPECT_TRUE(std::isinf(samples[10].radiance_stddev_rgb.z));
  EXPECT_LT(marked, 10);
}

TEST(SampleSelection, FollowsTheSunALittleWithoutDrawingAgain) {
  const SyntheticPicture picture;
  const SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  SampleSet set;
  set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
  const glm::dvec3 moved = glm::normalize(view.sun_direction_enu + glm::dvec3(0.01, 0.0, 0.0));
  std::vector<DiffuseSample> samples;
  set.Measure(moved, frame.radiance, frame.unusable, samples);
  ASSERT_FALSE(samples.empty());
  for (const DiffuseSample& sample : samples) {
    const std::size_t pixel = view.region.Index(sample.pixel.x, sample.pixel.y);
    const glm::vec3 response = SunResponse(view, pixel, moved);
    // Mean albedo of the footprint: the sky's transport over its response, which is even here.
    const double reflectance =
        sample.sky_transport_rgb[0].x / double{view.sky_response[0].pixels[pixel].x};
    EXPECT_NEAR(sample.sun_transport_rgb.x, reflectance * response.x, 1e-5 * reflectance);
  }
}

// Level ground seen from 2 m above by a camera that looks straight down, its place at `eye_m`, with
// a box of another region, 1 m high, where `box` says.
struct GroundFromAbove {
  SurfaceView view;
  Frame frame;

  explicit GroundFromAbove(const glm::dvec2& eye_m, bool box = false) {
    const int width = 160;
    const int height = 120;
    view = MakeView({.width = width, .height = height, .shadow_share = 0.0});
    view.camera.intrinsics = {width, height, 80.0, 80.0, 79.5, 59.5, {}};
    // Camera x is east, camera y south, camera z down.
    view.camera.camera_from_world = glm::dmat4(glm::dmat3(
        glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(0.0, -1.0, 0.0), glm::dvec3(0.0, 0.0, -1.0)));
    view.camera.camera_from_world[3] = glm::dvec4(-eye_m.x, eye_m.y, 2.0, 1.0);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::size_t pixel = view.region.Index(x, y);
        const bool on_box = box && x < 60;
        const double depth_m = on_box ? 1.0 : 2.0;
        view.region.pixels[pixel] = on_box ? 0 : 1;
        view.normal_world.pixels[pixel] = {0.0f, 0.0f, 1.0f};
        view.position_world_m.pixels[pixel] = glm::vec3(eye_m.x + (x - 79.5) / 80.0 * depth_m,
                                                        eye_m.y - (y - 59.5) / 80.0 * depth_m,
                                                        2.0 - depth_m);
        view.sun_visibility.pixels[pixel] = 1.0f;
        view.edge_distance_px.pixels[pixel] = static_cast<float>(
            std::min({x, y, width - 1 - x, height - 1 - y, box ? std::abs(x - 60) : width}));
      }
    }
    frame = MakeFrame({.width = width, .height = height, .shadow_share = 0.0}, view);
  }

  void Draw(SampleSet& set) const {
    set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
  }
  int Follow(SampleSet& set) const {
    return set.Follow(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
  }
  void Refill(SampleSet& set) const {
    set.Refill(view, view.sun_direction_enu, frame.radiance, frame.unusable, {});
  }
  std::vector<glm::ivec2> Pixels(const SampleSet& set) const {
    std::vector<DiffuseSample> samples;
    set.Measure(view.sun_direction_enu, frame.radiance, frame.unusable, samples);
    std::vector<glm::ivec2> pixels;
    pixels.reserve(samples.size());
    for (const DiffuseSample& sample : samples) pixels.push_back(sample.pixel);
    return pixels;
  }
};

// 0.25 m to the east: all that is seen moves by ten pixels to the left, one for 0.025 m.
TEST(SampleSelection, FollowsTheSurfacesWhereTheCameraMoves) {
  const GroundFromAbove first({0.0, 0.0});
  SampleSet set;
  first.Draw(set);
  const std::vector<glm::ivec2> before = first.Pixels(set);
  ASSERT_EQ(before.size(), 500u);
  const GroundFromAbove second({0.25, 0.0});
  const int left = second.Follow(set);
  EXPECT_LT(left, 500) << "those at the left border left the picture";
  EXPECT_GT(left, 400);
  const std::vector<glm::ivec2> after = second.Pixels(set);
  for (const glm::ivec2& pixel : after) {
    EXPECT_NE(std::find(before.begin(), before.end(), pixel + glm::ivec2(10, 0)), before.end());
  }
  second.Refill(set);
  const std::vector<glm::ivec2> refilled = second.Pixels(set);
  EXPECT_EQ(refilled.size(), 500u);
  for (const glm::ivec2& pixel : after) {
    EXPECT_EQ(std::count(refilled.begin(), refilled.end(), pixel), 1);
  }
  // There and back again they are where they were: no step adds to the last one's rounding.
  for (int i = 0; i < 20; ++i) GroundFromAbove({0.011 * i, 0.007 * i}).Follow(set);
  second.Follow(set);
  for (const glm::ivec2& pixel : second.Pixels(set)) {
    EXPECT_NE(std::find(refilled.begin(), refilled.end(), pixel), refilled.end());
  }
}

// Of a view that shows nothing else, it follows the same samples.
TEST(SampleSelection, FollowingReadsOnlyThePixelsThatItStates) {
  const GroundFromAbove first({0.0, 0.0});
  SampleSet set;
  first.Draw(set);
  const GroundFromAbove whole({0.25, 0.1});
  SampleSet of_whole = set;
  whole.Follow(of_whole);
  const std::vector<PixelRect> rects = set.PixelsFollowed(whole.view.camera);
  EXPECT_GE(rects.size(), static_cast<std::size_t>(of_whole.Size()));
  const auto is_read = [&](int x, int y) {
    return std::ranges::any_of(rects, [&](const PixelRect& rect) { return rect.Holds({x, y}); });
  };
  GroundFromAbove part = whole;
  SurfaceView& view = part.view;
  int left_out = 0;
  for (int y = 0; y < view.Height(); ++y) {
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (is_read(x, y)) {
        // The rim counts as an edge.
        constexpr int kFarPx = 12;
        for (int dy = -kFarPx; dy <= kFarPx; ++dy) {
          for (int dx = -kFarPx; dx <= kFarPx; ++dx) {
            if (!view.region.Contains(x + dx, y + dy) || is_read(x + dx, y + dy)) continue;
            view.edge_distance_px.pixels[pixel] = std::min(
                view.edge_distance_px.pixels[pixel], static_cast<float>(std::hypot(dx, dy)) - 1.0f);
          }
        }
        continue;
      }
      view.region.pixels[pixel] = SurfaceView::kNoRegion;
      view.may_be_sampled.pixels[pixel] = 0;
      view.albedo_rgb.pixels[pixel] = glm::vec3(0.0f);
      view.edge_distance_px.pixels[pixel] = 0.0f;
      ++left_out;
    }
  }
  EXPECT_GT(left_out, 100);
  part.Follow(set);
  EXPECT_EQ(part.Pixels(set), whole.Pixels(of_whole));
  EXPECT_TRUE(set.PixelsFollowed(GroundFromAbove({50.0, 0.0}).view.camera).empty());
}

TEST(SampleSelection, LeavesWhatIsHiddenOrOutOfView) {
  const GroundFromAbove open({0.0, 0.0});
  SampleSet set;
  open.Draw(set);
  const GroundFromAbove hidden({0.0, 0.0}, true);
  EXPECT_LT(hidden.Follow(set), 350);
  for (const glm::ivec2& pixel : hidden.Pixels(set)) EXPECT_GT(pixel.x, 60);
  EXPECT_EQ(GroundFromAbove({50.0, 0.0}).Follow(set), 0);
  open.Refill(set);
  EXPECT_EQ(open.Pixels(set).size(), 500u);
}

TEST(SampleSelection, AViewWithoutDiffuseSurfacesGivesNoSamples) {
  const SyntheticPicture picture;
  SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  std::fill(view.may_be_sampled.pixels.begin(), view.may_be_sampled.pixels.end(), 0);
  EXPECT_TRUE(DrawAndMeasure(view, frame).empty());
}

TEST(SampleSelection, RefusesImagesOfAnotherSize) {
  const SyntheticPicture picture;
  SurfaceView view = MakeView(picture);
  const Frame frame = MakeFrame(picture, view);
  SampleSet set;
  const RgbImage small(10, 10);
  EXPECT_THROW(set.Draw(view, view.sun_direction_enu, small, frame.unusable, {}),
               std::invalid_argument);
  EXPECT_THROW(set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {0, 1}),
               std::invalid_argument);
  view.sky_response.clear();
  EXPECT_THROW(set.Draw(view, view.sun_direction_enu, frame.radiance, frame.unusable, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::sample_selection_test

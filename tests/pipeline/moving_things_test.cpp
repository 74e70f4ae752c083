// What moves before a wall and a floor of which model and light are both a little wrong.
#include "pipeline/moving_things.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pleinair::moving_things_test {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kHorizon = 60;     // Wall above, floor below.
constexpr int kShadowFrom = 90;  // The floor's right part lies in shade.

struct Box {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
  bool Has(int x, int y) const {
    return x >= left && x < left + width && y >= top && y < top + height;
  }
};

// Pictures of a scene as its model predicts them, times what the model does not know.
class Street {
 public:
  Street() {
    view_.camera.intrinsics = {kWidth, kHeight, 100.0, 100.0, 79.5, 59.5, {}};
    view_.region_names = {"wall", "floor", "unseen"};
    view_.region = {kWidth, kHeight};
    view_.normal_world = {kWidth, kHeight};
    view_.albedo_rgb = {kWidth, kHeight, glm::vec3(0.3f)};
    view_.may_be_sampled = {kWidth, kHeight, 1};
    view_.sky_response = {Image<glm::vec3>(kWidth, kHeight, glm::vec3(0.8f))};
    view_.sun_visibility = {kWidth, kHeight, 1.0f};
    view_.sun_bounce = {kWidth, kHeight, glm::vec3(0.05f)};
    view_.edge_distance_px = {kWidth, kHeight};
    wrong_albedo_ = {kWidth, kHeight, glm::vec3(1.0f)};
    std::uniform_real_distribution<float> wrong(-0.7f, 0.7f);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool is_floor = y >= kHorizon;
        view_.region.At(x, y) = is_floor ? 1 : 0;
        view_.normal_world.At(x, y) = is_floor ? glm::vec3(0, 0, 1) : glm::vec3(0, -1, 0);
        view_.edge_distance_px.At(x, y) = std::abs(static_cast<float>(y - kHorizon) + 0.5f);
        if (is_floor && x >= kShadowFrom) view_.sun_visibility.At(x, y) = 0.0f;
        // Half or twice as bright as the model has it, from pixel to pixel.
        wrong_albedo_.At(x, y) = glm::vec3(std::exp(wrong(random_)));
      }
    }
  }

  // The sun's share of the light differs from frame to frame, and so does the error of the
  // estimate.
  Lighting LightOf(int frame) const {
    Lighting lighting;
    lighting.sun.direction_enu = {0.0, -0.6, 0.8};
    lighting.sun.irradiance_rgb = glm::dvec3(400.0 + 200.0 * std::sin(frame));
    lighting.sky = {{"uniform", glm::dvec3(150.0, 160.0, 180.0)}};
    return lighting;
  }
  Frame PictureOf(int number) {
    Frame frame;
    frame.index = number;
    frame.camera = view_.camera;
    frame.radiance = {kWidth, kHeight};
    frame.unusable = {kWidth, kHeight};
    Lighting light = LightOf(number);
    light.sun.irradiance_rgb *= 1.0 + 0.2 * std::cos(2.0 * number);
    light.sky[0].irradiance_rgb *= 1.0 - 0.2 * std::cos(2.0 * number);
    std::normal_distribution<float> noise(1.0f, 0.03f);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const std::size_t pixel = view_.region.Index(x, y);
        glm::dvec3 irradiance = light.sky[0].irradiance_rgb * glm::dvec3(0.8);
        irradiance += light.sun.irradiance_rgb *
                      glm::dvec3(SunResponse(view_, pixel, light.sun.direction_enu));
        frame.radiance.pixels[pixel] =
            glm::vec3(irradiance) * 0.3f / 3.14159f * wrong_albedo_.pixels[pixel] * noise(random_);
      }
    }
    return frame;
  }
  void Paint(Frame& frame, const Box& box, const glm::vec3& factor) const {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (box.Has(x, y)) frame.radiance.At(x, y) *= factor;
      }
    }
  }

  SurfaceView view_;
  RgbImage wrong_albedo_;
  std::mt19937 random_{5};
};

int Masked(const Gray8Image& mask) {
  int count = 0;
  for (const std::uint8_t pixel : mask.pixels) count += pixel == 0;
  return count;
}

constexpr int kFrames = 16;

TEST(MovingThings, NothingMovesWhereModelAndLightAreWrongAllTheTime) {
  Street street;
  MovingThings things;
  for (int f = 0; f < kFrames; ++f) {
    EXPECT_TRUE(things.Add(street.PictureOf(f), street.view_, street.LightOf(f)));
  }
  const MovingThingsFound found = things.Find();
  EXPECT_EQ(found.frames, kFrames);
  EXPECT_EQ(Masked(found.mask), 0);
  // The noise, and no more of the light's error of 20 %.
  EXPECT_NEAR(found.typical_change, 0.03, 0.015);
  ASSERT_EQ(found.regions.size(), 2u);
  EXPECT_EQ(found.regions[1].name, "floor");
  EXPECT_EQ(found.regions[1].pixels, kWidth * (kHeight - kHorizon));
}

// A red car drives along the floor, in and out of the shade, and a dark one stands for a third of
// the time.
TEST(MovingThings, WhatDrivesAndWhatParksIsMaskedAndLittleElse) {
  Street street;
  MovingThings things;
  const Box parked{20, 70, 24, 10};
  for (int f = 0; f < kFrames; ++f) {
    Frame frame = street.PictureOf(f);
    street.Paint(frame, {10 * f - 20, 90, 36, 20}, {1.8f, 0.5f, 0.5f});
    if (f % 3 == 1) street.Paint(frame, parked, glm::vec3(0.1f));
    things.Add(frame, street.view_, street.LightOf(f));
  }
  const MovingThingsFound found = things.Find();
  int missed = 0;
  int in_vain = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool is_masked = found.mask.At(x, y) == 0;
      const bool moves = parked.Has(x, y) || Box{0, 90, 150, 20}.Has(x, y);
      // The margin of a block, here a pixel, on either side.
      const bool is_near = Box{18, 68, 28, 14}.Has(x, y) || Box{0, 88, 160, 24}.Has(x, y);
      missed += moves && !is_masked;
      in_vain += !is_near && is_masked;
    }
  }
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(in_vain, 0);
  EXPECT_NEAR(found.hidden_share.At(30, 75), 5.0 / kFrames, 1e-6);
}

// A shadow that the mesh lacks is nothing that moves in front of the surface.
TEST(MovingThings, AShadowInTheWrongPlaceIsNotMasked) {
  Street street;
  MovingThings things;
  for (int f = 0; f < kFrames; ++f) {
    const SurfaceView model = street.view_;
    for (int y = kHorizon; y < kHeight; ++y) {
      for (int x = 4 * f; x < 4 * f + 24; ++x) street.view_.sun_visibility.At(x, y) = 0.0f;
    }
    const Frame frame = street.PictureOf(f);
    street.view_ = model;
    things.Add(frame, street.view_, street.LightOf(f));
  }
  EXPECT_EQ(Masked(things.Find().mask), 0);
}

// Once is too seldom to leave a surface out; it is reported.
TEST(MovingThings, WhatPassesOnceIsOnlyReported) {
  Street street;
  MovingThings things;
  for (int f = 0; f < kFrames; ++f) {
    Frame frame = street.PictureOf(f);
    if (f == 7) street.Paint(frame, {40, 10, 30, 30}, glm::vec3(3.0f));
    things.Add(frame, street.view_, street.LightOf(f));
  }
  const MovingThingsFound found = things.Find();
  EXPECT_EQ(Masked(found.mask), 0);
  EXPECT_NEAR(found.hidden_share.At(55, 25), 1.0 / kFrames, 1e-6);
}

// Frames of 4 pixels a block give the same place, a block around it included.
TEST(MovingThings, BlocksCoverWhatTheirPixelsShow) {
  Street street;
  MovingThingsOptions options;
  options.most_blocks = kWidth * kHeight / 16;
  MovingThings things(options);
  for (int f = 0; f < kFrames; ++f) {
    Frame frame = street.PictureOf(f);
    if (f % 4 == 0) street.Paint(frame, {80, 80, 32, 24}, {0.3f, 0.2f, 2.0f});
    things.Add(frame, street.view_, street.LightOf(f));
  }
  const MovingThingsFound found = things.Find();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool is_masked = found.mask.At(x, y) == 0;
      EXPECT_LE((Box{80, 80, 32, 24}.Has(x, y)), is_masked);
      EXPECT_LE(is_masked, (Box{74, 74, 44, 36}.Has(x, y)));
    }
  }
}

TEST(MovingThings, WhatIsNotASurfaceOrNotUsableIsNotLookedAt) {
  Street street;
  for (int x = 0; x < 20; ++x) street.view_.region.At(x, 20) = SurfaceView::kNoRegion;
  MovingThings things;
  for (int f = 0; f < kFrames; ++f) {
    Frame frame = street.PictureOf(f);
    const Box box{100, 10, 30, 30};
    if (f % 2 == 0) street.Paint(frame, box, glm::vec3(5.0f));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (box.Has(x, y)) frame.unusable.At(x, y) = kUnusable;
      }
    }
    frame.radiance.At(5, 100) = glm::vec3(std::numeric_limits<float>::quiet_NaN());
    frame.radiance.At(6, 100) = glm::vec3(std::numeric_limits<float>::infinity());
    frame.radiance.At(7, 100) = glm::vec3(0.0f);
    EXPECT_TRUE(things.Add(frame, street.view_, street.LightOf(f)));
    frame.camera.intrinsics.fx_px += 1.0;
    SurfaceView other = street.view_;
    other.camera = frame.camera;
    EXPECT_FALSE(things.Add(frame, other, street.LightOf(f)));
  }
  const MovingThingsFound found = things.Find();
  EXPECT_EQ(found.frames, kFrames);
  EXPECT_EQ(Masked(found.mask), 0);
}

TEST(MovingThings, WithoutFramesThereIsNothingAndOptionsAreChecked) {
  const MovingThingsFound found = MovingThings().Find();
  EXPECT_EQ(found.frames, 0);
  EXPECT_TRUE(found.mask.Empty());
  MovingThingsOptions options;
  options.least_change = 0.0;
  EXPECT_THROW(MovingThings{options}, std::invalid_argument);
  options = {};
  options.least_share = std::nan("");
  EXPECT_THROW(MovingThings{options}, std::invalid_argument);
  options = {};
  options.most_blocks = 0;
  EXPECT_THROW(MovingThings{options}, std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::moving_things_test

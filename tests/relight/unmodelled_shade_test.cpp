// Shade of things that the mesh lacks, in a survey's map of a level ground.
#include "relight/survey/internal/unmodelled_shade.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/lat_long.h"

namespace pleinair::unmodelled_shade_test {
namespace {

constexpr float kEyeM = 1.6f;
const glm::vec3 kSun(1000.0f, 920.0f, 800.0f);
const glm::vec3 kSky(120.0f, 160.0f, 230.0f);
const glm::vec3 kToSun = glm::normalize(glm::vec3(0.6f, 0.2f, 0.8f));
const glm::vec3 kPaving(0.3f);
const glm::vec3 kBrick(0.40f, 0.25f, 0.18f);

class UnmodelledShadeTest : public testing::Test {
 protected:
  explicit UnmodelledShadeTest(const LatLongSize& size = {512, 256}) : size_(size) {
    view_.region = Image<std::int32_t>(size_.width, size_.height, SurfaceView::kNoRegion);
    view_.position_world_m = RgbImage(size_.width, size_.height);
    view_.normal_world = RgbImage(size_.width, size_.height, glm::vec3(0.0f, 0.0f, 1.0f));
    view_.sky_response.assign(1, RgbImage(size_.width, size_.height, glm::vec3(1.0f)));
    view_.sun_bounce = RgbImage(size_.width, size_.height, glm::vec3(0.0f));
    view_.sun_direction_enu = glm::dvec3(kToSun);
    side_ = Image<ShadowSide>(size_.width, size_.height, ShadowSide::kUnsure);
    for (int y = size_.height / 2 + 4; y < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) {
        const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, size_));
        view_.region.At(x, y) = 0;
        view_.position_world_m.At(x, y) =
            glm::vec3(0.0f, 0.0f, kEyeM) - direction * (kEyeM / direction.z);
        side_.At(x, y) = ShadowSide::kLit;
      }
    }
  }

  // What a camera with soft pixels sees of a ground of that albedo, a tenth of stains beside, under
  // these shares of the sun and the sky.
  RgbImage Map(const std::function<glm::vec3(const glm::vec3&)>& albedo_at,
               const std::function<glm::vec2(const glm::vec3&)>& sun_and_sky_at) const {
    std::mt19937 random(1);
    std::normal_distribution<float> stain(0.0f, 0.1f);
    RgbImage sharp(size_.width, size_.height, glm::vec3(0.0f));
    for (std::size_t i = 0; i < sharp.pixels.size(); ++i) {
      if (view_.region.pixels[i] == SurfaceView::kNoRegion) continue;
      const glm::vec3& at_m = view_.position_world_m.pixels[i];
      const glm::vec2 shares = sun_and_sky_at(at_m);
      sharp.pixels[i] = std::exp(stain(random)) * std::numbers::inv_pi_v<float> * albedo_at(at_m) *
                        (shares.y * sky_ + shares.x * kToSun.z * sun_);
    }
    RgbImage soft = sharp;
    for (int y = size_.height / 2 + 5; y + 1 < size_.height; ++y) {
      for (int x = 0; x < size_.width; ++x) {
        const int left = (x + size_.width - 1) % size_.width;
        const int right = (x + 1) % size_.width;
        soft.At(x, y) = 0.5f * sharp.At(x, y) + 0.125f * (sharp.At(left, y) + sharp.At(right, y) +
                                                          sharp.At(x, y - 1) + sharp.At(x, y + 1));
      }
    }
    return soft;
  }

  UnmodelledShade Find(const RgbImage& map) const {
    return FindUnmodelledShade({.radiance = map,
                                .view = view_,
                                .side = side_,
                                .sun_irradiance_rgb = sun_,
                                .sky_irradiance_rgb = sky_});
  }

  // Of the pixels whose place is within `radius_m` of a tree's shade, or beyond it.
  struct Share {
    int pixels = 0;
    int in_shade = 0;
    double albedo = 0.0;  // The mean of those in shade.
  };
  Share InsideOf(const UnmodelledShade& found, float radius_m) const {
    return ShareOf(found, [=](float from_middle_m) { return from_middle_m < radius_m; });
  }
  Share OutsideOf(const UnmodelledShade& found, float radius_m) const {
    return ShareOf(found, [=](float from_middle_m) { return from_middle_m > radius_m; });
  }

  static constexpr float kShadeM = 1.2f;  // Radius of the shade around kMiddleM.
  static float FromMiddleM(const glm::vec3& at_m) { return glm::distance(at_m, kMiddleM); }

  LatLongSize size_;
  glm::vec3 sun_ = kSun;
  glm::vec3 sky_ = kSky;

 private:
  static constexpr glm::vec3 kMiddleM{2.0f, 1.5f, 0.0f};

  Share ShareOf(const UnmodelledShade& found, const std::function<bool(float)>& counts) const {
    Share share;
    for (std::size_t i = 0; i < view_.region.pixels.size(); ++i) {
      if (view_.region.pixels[i] == SurfaceView::kNoRegion) continue;
      if (!counts(FromMiddleM(view_.position_world_m.pixels[i]))) continue;
      ++share.pixels;
      if (found.is_in_shade.pixels[i] == 0) continue;
      ++share.in_shade;
      share.albedo += found.albedo_rgb.pixels[i].g;
    }
    if (share.in_shade > 0) share.albedo /= share.in_shade;
    return share;
  }

  SurfaceView view_;
  Image<ShadowSide> side_;
};

glm::vec3 Paved(const glm::vec3& /*at_m*/) { return kPaving; }

TEST_F(UnmodelledShadeTest, IsFoundWithTheAlbedoOfTheSunlitSurface) {
  for (const glm::vec3& paving : {kPaving, kBrick}) {
    for (const float sky_left : {1.0f, 0.6f}) {
      const UnmodelledShade found = Find(Map([&](const glm::vec3&) { return paving; },
                                             [&](const glm::vec3& at_m) {
                                               return FromMiddleM(at_m) < kShadeM
                                                          ? glm::vec2(0.0f, sky_left)
                                                          : glm::vec2(1.0f);
                                             }));
      const Share inside = InsideOf(found, 0.9f * kShadeM);
      EXPECT_GT(inside.in_shade, 0.95 * inside.pixels) << paving.r << " " << sky_left;
      EXPECT_NEAR(inside.albedo, paving.g, 0.1 * paving.g) << paving.r << " " << sky_left;
      EXPECT_LT(OutsideOf(found, 1.3f * kShadeM).in_shade, 50) << paving.r << " " << sky_left;
    }
  }
}

class FineUnmodelledShadeTest : public UnmodelledShadeTest {
 protected:
  FineUnmodelledShadeTest() : UnmodelledShadeTest({2048, 1024}) {}
};

// In a fine map the blur of the edge is many pixels wide, and takes its albedo from some of those
// around: it is the paving's on both sides of the edge.
TEST_F(FineUnmodelledShadeTest, HasTheSunlitSurfacesAlbedoInItsBlur) {
  const UnmodelledShade found = Find(Map(Paved, [](const glm::vec3& at_m) {
    return FromMiddleM(at_m) < kShadeM ? glm::vec2(0.0f, 1.0f) : glm::vec2(1.0f);
  }));
  const Share inside = InsideOf(found, kShadeM);
  EXPECT_GT(inside.in_shade, 0.99 * inside.pixels);
  const Share outside = OutsideOf(found, kShadeM);
  EXPECT_GT(outside.in_shade, 1000);
  EXPECT_NEAR(outside.albedo, kPaving.g, 0.02 * kPaving.g);
}

// Asphalt of a shade's level in the sun, and paint of another colour and level. Asphalt beside warm
// paving differs from it by nearly the step of a shade: beside brick by that in level and hue, but
// not in green; beside sand by that in level and green, but not in hue.
TEST_F(UnmodelledShadeTest, IsNotADarkerSurfaceInTheSun) {
  const glm::vec3 asphalt(0.055f);
  struct Ground {
    glm::vec3 paving;
    glm::vec3 dark;
  };
  for (const Ground& ground : {Ground{kPaving, asphalt},
                               Ground{kPaving, {0.03f, 0.06f, 0.15f}},
                               Ground{kPaving, {0.12f, 0.05f, 0.04f}},
                               Ground{kBrick, asphalt},
                               Ground{{0.36f, 0.30f, 0.21f}, asphalt}}) {
    const UnmodelledShade found = Find(Map(
        [&](const glm::vec3& at_m) {
          return FromMiddleM(at_m) < kShadeM ? ground.dark : ground.paving;
        },
        [](const glm::vec3&) { return glm::vec2(1.0f); }));
    EXPECT_EQ(found.pixels, 0u) << ground.paving.r << " " << ground.dark.r << " " << ground.dark.b;
  }
}

TEST_F(UnmodelledShadeTest, IsNotLookedForWhereItsColourSaysNothing) {
  sun_ = glm::vec3(1000.0f);
  sky_ = glm::vec3(150.0f);
  EXPECT_EQ(Find(Map(Paved,
                     [](const glm::vec3& at_m) {
                       return FromMiddleM(at_m) < kShadeM ? glm::vec2(0.0f, 1.0f) : glm::vec2(1.0f);
                     }))
                .pixels,
            0u);
}

TEST_F(UnmodelledShadeTest, NeedsASunAndAPicture) {
  const RgbImage map = Map(Paved, [](const glm::vec3&) { return glm::vec2(1.0f); });
  EXPECT_EQ(Find(map).pixels, 0u);
  EXPECT_EQ(Find(RgbImage(size_.width, size_.height, glm::vec3(0.0f))).pixels, 0u);
  sun_ = glm::vec3(0.0f);
  EXPECT_EQ(Find(map).pixels, 0u);
}

}  // namespace
}  // namespace pleinair::unmodelled_shade_test

// Shade that the picture shows and the mesh does not cast, on virtual objects.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/mat3x3.hpp>

#include "calib/lens.h"
#include "ground_stage.h"

namespace pleinair::seen_shade_test {
namespace {

constexpr float kAlbedo = 0.8f;
const Material kWhite{.name = "white", .diffuse_albedo = glm::vec3(kAlbedo)};
// Light of a level place, with and without the sun, which stands 45 degrees high in the east.
constexpr double kLit = StillLight::kSky + StillLight::kSun * std::numbers::sqrt2 / 2.0;
constexpr double kShaded = StillLight::kSky;

glm::dvec2 PixelOf(const Camera& camera, const glm::dvec3& place_m) {
  return ProjectToPixel(camera.intrinsics,
                        glm::dvec3(camera.camera_from_world * glm::dvec4(place_m, 1.0)))
      .value();
}

class SeenShade : public testing::Test {
 protected:
  // The ground's light changed by a factor that depends on the place.
  Frame WithFactor(const std::function<double(const glm::dvec3&)>& factor_at) const {
    Frame frame = stage_.MakeFrame();
    const glm::dmat4 world_from_camera = glm::inverse(frame.camera.camera_from_world);
    const glm::dvec3 eye = frame.camera.CentreWorldM();
    for (int y = 0; y < frame.radiance.height; ++y) {
      for (int x = 0; x < frame.radiance.width; ++x) {
        const glm::dvec3 in_camera = DirectionFromPixel(frame.camera.intrinsics, {x, y}).value();
        const glm::dvec3 ray = glm::dmat3(world_from_camera) * in_camera;
        if (ray.z < 0.0) {
          frame.radiance.At(x, y) *= static_cast<float>(factor_at(eye - ray * (eye.z / ray.z)));
        }
      }
    }
    return frame;
  }

  FramePipeline PipelineOf(const std::vector<VirtualObject>& objects,
                           double sun = StillLight::kSun) {
    return PipelineOf(objects, std::make_unique<StillLight>(sun));
  }
  FramePipeline PipelineOf(const std::vector<VirtualObject>& objects,
                           std::unique_ptr<LightingSource> light) {
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.effects = EffectSettings::Everything();
    options.effects[Effect::kCameraBlur] = EffectSwitch::kOff;
    return {{stage_.Scene(), stage_.Phantom(), std::nullopt, objects},
            std::move(light),
            compositor_,
            options};
  }

  FrameResult Process(const Frame& frame, const VirtualObject& object, double sun) {
    return PipelineOf({object}, sun).Process(frame).value();
  }

  // Irradiance of an object's place, by the composite.
  static double At(const FrameResult& result, const Camera& camera, const glm::dvec3& place_m) {
    const glm::dvec2 at = PixelOf(camera, place_m);
    const auto x = static_cast<int>(std::lround(at.x));
    const auto y = static_cast<int>(std::lround(at.y));
    return result.composite.radiance.At(x, y).g * std::numbers::pi / kAlbedo;
  }

  // Of the top of a box 0.9 m high.
  double OnTop(const Frame& frame, double x_m, double sun = StillLight::kSun) {
    const FrameResult result =
        Process(frame, BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite), sun);
    return At(result, frame.camera, {x_m, 0.0, 0.9});
  }

  // About the vertical through the origin.
  static VirtualObject Turned(VirtualObject object, float angle_deg) {
    const glm::mat3 turn(
        glm::rotate(glm::mat4(1.0f), glm::radians(angle_deg), glm::vec3(0.0f, 0.0f, 1.0f)));
    for (glm::vec3& position_m : object.mesh.positions_m) position_m = turn * position_m;
    for (glm::vec3& normal : object.mesh.normals) normal = turn * normal;
    return object;
  }

  static Material Chrome() {
    Material chrome{.name = "chrome", .diffuse_albedo = glm::vec3(0.0f)};
    chrome.specular_reflectance = glm::vec3(0.9f);
    chrome.roughness = 0.02f;
    return chrome;
  }

  // Irradiance of an object's brightest pixel.
  static double Brightest(const FrameResult& result) {
    float value = 0.0f;
    for (std::size_t i = 0; i < result.composite.radiance.pixels.size(); ++i) {
      if (result.composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kCovered)) {
        value = std::max(value, result.composite.radiance.pixels[i].g);
      }
    }
    return value * std::numbers::pi / kAlbedo;
  }

  const GroundStage stage_;
  const HeadlessContext context_;
  Compositor compositor_;
};

// The shadow of the top's middle falls 0.9 m to the west: a tree's shade ends there.
TEST_F(SeenShade, FallsOnTheObjectWhereItsShadowWouldFall) {
  const Frame frame =
      WithFactor([](const glm::dvec3& at_m) { return at_m.x < -0.9 ? kShaded / kLit : 1.0; });
  EXPECT_NEAR(OnTop(frame, -0.3), kShaded, 0.03 * kShaded);
  EXPECT_NEAR(OnTop(frame, 0.3), kLit, 0.03 * kLit);
}

TEST_F(SeenShade, IsOnlyWhatLooksLikeTheSurfaceInShade) {
  const Frame black = WithFactor([](const glm::dvec3& at_m) { return at_m.x < -0.9 ? 0.03 : 1.0; });
  EXPECT_NEAR(OnTop(black, -0.3), kLit, 0.03 * kLit) << "a black thing";
  const Frame stained = WithFactor([](const glm::dvec3& at_m) {
    return std::hypot(at_m.x + 1.2, at_m.y) < 0.1 ? kShaded / kLit : 1.0;
  });
  EXPECT_NEAR(OnTop(stained, -0.3), kLit, 0.03 * kLit) << "a stain";
  const Frame darker = WithFactor([](const glm::dvec3&) { return 0.75; });
  EXPECT_NEAR(OnTop(darker, -0.3), kLit, 0.03 * kLit) << "ground darker than its albedo";
}

// A car that the mesh lacks covers the ground: what it reflects is no evidence of shade.
TEST_F(SeenShade, NeedsMoreThanAPixelAmongDarkOnes) {
  const Frame frame = WithFactor([](const glm::dvec3& at_m) {
    if (at_m.x > -0.5) return 1.0;
    return std::hypot(at_m.x + 1.2, at_m.y) < 0.1 ? kShaded / kLit : 0.03;
  });
  EXPECT_NEAR(OnTop(frame, -0.3), kLit, 0.03 * kLit);
}

TEST_F(SeenShade, TakesNothingFromTheSky) {
  const Frame frame = WithFactor([](const glm::dvec3&) { return kShaded / kLit; });
  EXPECT_NEAR(OnTop(frame, 0.3, 0.0), kShaded, 0.03 * kShaded) << "no sun";
  EXPECT_NEAR(OnTop(frame, 0.3), kShaded, 0.03 * kShaded) << "all in shade";
}

// In the picture a slab 4 px wide covers a part of a box's top. The slab's shadow falls into a
// strip of shade, the box's beside it. Windows around the slab have more pixels of the box.
TEST_F(SeenShade, FallsOnTheOneOfTwoObjects) {
  const Frame frame = WithFactor([](const glm::dvec3& at_m) {
    return at_m.x > -2.1 && at_m.x < -1.35 ? kShaded / kLit : 1.0;
  });
  const FrameResult result =
      PipelineOf({BoxObject({-0.3f, -1.4f, 1.4f}, {-0.1f, -0.6f, 1.5f}, kWhite),
                  BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite)})
          .Process(frame)
          .value();
  for (const double y_m : {-1.2, -1.0, -0.8}) {
    EXPECT_NEAR(At(result, frame.camera, {-0.2, y_m, 1.5}), kShaded, 0.05 * kShaded) << y_m;
  }
  for (const double y_m : {-0.2, 0.0, 0.2}) {
    for (const double x_m : {0.1, 0.35}) {
      EXPECT_NEAR(At(result, frame.camera, {x_m, y_m, 0.9}), kLit, 0.05 * kLit) << x_m;
    }
  }
}

// Known in its first frame, and then uncertain: a cloud comes.
class FadingLight : public StillLight {
 public:
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    LightingEstimate estimate = StillLight::Estimate(observation).value();
    constexpr std::size_t kSide = 6;
    estimate.lighting.covariance.assign(kSide * kSide, 0.0);
    if (frames_++ == 0) return estimate;
    for (std::size_t i = 0; i < kSide; ++i) {
      estimate.lighting.covariance[i * (kSide + 1)] = kSun * kSun;
    }
    return estimate;
  }

 private:
  int frames_ = 0;
};

// In the east.
glm::dvec3 SunAt(double elevation_deg) {
  const double elevation = glm::radians(elevation_deg);
  return {std::cos(elevation), 0.0, std::sin(elevation)};
}

// The house that casts the shade still stands.
TEST_F(SeenShade, IsHeldWhileTheLightIsUncertain) {
  const VirtualObject box = BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite);
  const Frame shaded = WithFactor([](const glm::dvec3&) { return kShaded / kLit; });
  const Frame sunlit = stage_.MakeFrame();
  const auto on_top_of_second = [&](const Frame& first, const Frame& second) {
    FramePipeline pipeline = PipelineOf({box}, std::make_unique<FadingLight>());
    pipeline.Process(first).value();
    return At(pipeline.Process(second).value(), second.camera, {0.3, 0.0, 0.9});
  };
  EXPECT_NEAR(on_top_of_second(shaded, shaded), kShaded, 0.03 * kShaded);
  EXPECT_NEAR(on_top_of_second(sunlit, shaded), kLit, 0.03 * kLit) << "not seen before";
  Frame later = shaded;
  later.sun_direction_enu = SunAt(47.0);
  EXPECT_NEAR(on_top_of_second(shaded, later), kShaded, 0.03 * kShaded) << "the sun moves little";
  later.sun_direction_enu = SunAt(55.0);
  const double lit = StillLight::kSky + StillLight::kSun * later.sun_direction_enu->z;
  EXPECT_NEAR(on_top_of_second(shaded, later), lit, 0.03 * lit) << "the sun has moved on";
}

// Pixels at the edge of a face that is turned away from the sun and one that is not.
TEST_F(SeenShade, FallsOnEdges) {
  const Frame frame = WithFactor([](const glm::dvec3&) { return kShaded / kLit; });
  const VirtualObject box = BoxObject({-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 0.9f}, kWhite);
  // Half of what a wall sees is the sky, half is the ground, which has the model's light.
  const double of_wall = (StillLight::kSky + GroundStage::kAlbedo * kLit) / 2.0;
  for (const float angle_deg : {30.0f, 40.0f, 50.0f}) {
    EXPECT_LT(Brightest(Process(frame, Turned(box, angle_deg), StillLight::kSun)), 1.03 * of_wall)
        << angle_deg;
  }
}

// The sun grazes a wall that faces the camera: the shadows of all its places fall in few pixels.
TEST_F(SeenShade, IgnoresBrightSpotsInWhichManyShadowsFall) {
  const VirtualObject wall =
      Turned(BoxObject({-0.6f, -0.05f, 0.0f}, {0.6f, 0.05f, 1.5f}, kWhite), 10.0f);
  const Frame shade = WithFactor([](const glm::dvec3&) { return kShaded / kLit; });
  // 14 by 2 pixels.
  const Frame spot = WithFactor([](const glm::dvec3& at_m) {
    return at_m.x > -1.5 && at_m.x < -0.65 && std::abs(at_m.y + 0.1) < 0.1 ? 1.0 : kShaded / kLit;
  });
  const FrameResult expected = Process(shade, wall, StillLight::kSun);
  const FrameResult result = Process(spot, wall, StillLight::kSun);
  int places = 0;
  for (int y = 0; y < spot.radiance.height; ++y) {
    for (int x = 0; x < spot.radiance.width; ++x) {
      if (expected.composite.change.At(x, y) != static_cast<std::uint8_t>(PixelChange::kCovered)) {
        continue;
      }
      ++places;
      EXPECT_LT(result.composite.radiance.At(x, y).g,
                1.1f * expected.composite.radiance.At(x, y).g + 1.0f)
          << x << ", " << y;
    }
  }
  EXPECT_GT(places, 200);
}

// A ball of chrome mirrors the ground around it. Where the camera sees that ground in shade, the
// mirrored one is in shade too; the ground behind the camera is as the mesh says.
TEST_F(SeenShade, IsMirrored) {
  const VirtualObject ball = BallObject({0.0f, 0.0f, 0.8f}, 0.8f, 48, Chrome());
  const Frame lit = stage_.MakeFrame();
  const Frame shaded = WithFactor([](const glm::dvec3&) { return kShaded / kLit; });
  const FrameResult in_sun = Process(lit, ball, StillLight::kSun);
  const FrameResult in_shade = Process(shaded, ball, StillLight::kSun);
  const float ground = 0.9f * lit.radiance.At(2, 70).g;
  int mirrored = 0;
  int fallen = 0;
  for (int y = 0; y < lit.radiance.height; ++y) {
    for (int x = 0; x < lit.radiance.width; ++x) {
      if (in_sun.composite.change.At(x, y) != static_cast<std::uint8_t>(PixelChange::kCovered)) {
        continue;
      }
      const float before = in_sun.composite.radiance.At(x, y).g;
      const float after = in_shade.composite.radiance.At(x, y).g;
      if (std::abs(before - ground) > 0.1f * ground) continue;
      ++mirrored;
      if (std::abs(after - before * static_cast<float>(kShaded / kLit)) < 0.1f * ground) ++fallen;
    }
  }
  EXPECT_GT(mirrored, 50);
  EXPECT_GT(fallen, mirrored / 3);
}

// The ball shows what the mesh and the light say, whatever the noise in the picture.
TEST_F(SeenShade, IsMirroredWithoutThePicturesNoise) {
  const VirtualObject ball = BallObject({0.0f, 0.0f, 0.8f}, 0.8f, 48, Chrome());
  const Frame still = stage_.MakeFrame();
  Frame noisy = still;
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0.0f, 0.1f);
  for (glm::vec3& radiance : noisy.radiance.pixels) {
    radiance *= 1.0f + glm::vec3(normal(random), normal(random), normal(random));
  }
  const FrameResult expected = Process(still, ball, StillLight::kSun);
  const FrameResult result = Process(noisy, ball, StillLight::kSun);
  const float ground = 0.9f * still.radiance.At(2, 70).g;
  int mirrored = 0;
  for (int y = 1; y + 1 < still.radiance.height; ++y) {
    for (int x = 1; x + 1 < still.radiance.width; ++x) {
      bool is_inside = true;
      for (int k = 0; k < 9; ++k) {
        is_inside = is_inside && expected.composite.change.At(x + k % 3 - 1, y + k / 3 - 1) ==
                                     static_cast<std::uint8_t>(PixelChange::kCovered);
      }
      if (!is_inside) continue;
      ++mirrored;
      EXPECT_NEAR(result.composite.radiance.At(x, y).g,
                  expected.composite.radiance.At(x, y).g,
                  0.1f * ground)
          << x << ", " << y;
    }
  }
  EXPECT_GT(mirrored, 300);
}

// Frames of one still camera, with noise of that share of the ground's light.
TEST_F(SeenShade, DoesNotFlickerWithNoise) {
  const auto half_in_shade = [](const glm::dvec3& at_m) {
    return at_m.x < -0.9 ? kShaded / kLit : 1.0;
  };
  const auto in_the_sun = [](const glm::dvec3&) { return 1.0; };
  for (const double noise_share : {0.03, 0.1, 0.2}) {
    std::mt19937 random(1);
    std::normal_distribution<float> normal(0.0f, static_cast<float>(noise_share));
    for (const bool is_half : {true, false}) {
      FramePipeline pipeline =
          PipelineOf({BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite)});
      double least_lit = kLit;
      double most_shaded = 0.0;
      for (int k = 0; k < 12; ++k) {
        Frame frame = is_half ? WithFactor(half_in_shade) : WithFactor(in_the_sun);
        for (glm::vec3& radiance : frame.radiance.pixels) {
          radiance *= 1.0f + glm::vec3(normal(random), normal(random), normal(random));
        }
        const FrameResult result = pipeline.Process(frame).value();
        least_lit = std::min(least_lit, At(result, frame.camera, {0.3, 0.0, 0.9}));
        most_shaded = std::max(most_shaded, At(result, frame.camera, {-0.3, 0.0, 0.9}));
      }
      EXPECT_NEAR(least_lit, kLit, 0.03 * kLit) << noise_share;
      if (is_half) {
        EXPECT_NEAR(most_shaded, kShaded, 0.03 * kShaded) << noise_share;
      }
    }
  }
}

// With a camera at rest the search is repeated, and the plan knows its cost; without a sun not.
TEST_F(SeenShade, IsInThePlan) {
  const VirtualObject box = BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite);
  for (const double sun : {StillLight::kSun, 0.0}) {
    FramePipeline pipeline = PipelineOf({box}, sun);
    const Frame frame = stage_.MakeFrame();
    FrameResult result = pipeline.Process(frame).value();
    result = pipeline.Process(frame).value();
    const auto work =
        std::find_if(result.works.begin(), result.works.end(), [](const PlannedWork& planned) {
          return planned.name == "seen shade on objects";
        });
    ASSERT_NE(work, result.works.end());
    EXPECT_EQ(work->is_kept, sun == 0.0);
    EXPECT_EQ(work->expected_ms > 0.0, sun > 0.0);
  }
}

// The shade leaves, and the object has all of the sun again, from what is kept of the mesh.
TEST_F(SeenShade, LeavesWithThePicture) {
  const VirtualObject box = BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite);
  FramePipeline pipeline = PipelineOf({box});
  const Frame shaded = WithFactor([](const glm::dvec3&) { return kShaded / kLit; });
  const Frame lit = stage_.MakeFrame();
  for (const Frame* frame : {&lit, &shaded, &shaded, &lit, &lit}) {
    const double expected = frame == &lit ? kLit : kShaded;
    const FrameResult result = pipeline.Process(*frame).value();
    EXPECT_NEAR(At(result, frame->camera, {0.3, 0.0, 0.9}), expected, 0.03 * expected);
  }
}

// Of a ball at the picture's left edge, most of the shadow falls outside.
TEST_F(SeenShade, GoesOnWhereTheShadowIsNotInThePicture) {
  const Frame frame =
      WithFactor([](const glm::dvec3& at_m) { return at_m.x < -1.2 ? kShaded / kLit : 1.0; });
  const VirtualObject ball = BallObject({-1.7f, 0.0f, 0.8f}, 0.8f, 24, kWhite);
  // Facing the sun it has all of it, and light from the ground; in the shade there is no more than
  // what comes from all around.
  EXPECT_GT(Brightest(Process(stage_.MakeFrame(), ball, StillLight::kSun)), StillLight::kSun);
  EXPECT_LT(Brightest(Process(frame, ball, StillLight::kSun)), 0.6 * StillLight::kSun);
}

}  // namespace
}  // namespace pleinair::seen_shade_test

// Shade that the picture shows and the mesh does not cast, on virtual objects.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>

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

  FrameResult Process(const Frame& frame, const VirtualObject& object, double sun) {
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.effects = EffectSettings::Everything();
    options.effects[Effect::kCameraBlur] = EffectSwitch::kOff;
    FramePipeline pipeline({stage_.Scene(), stage_.Phantom(), std::nullopt, {object}},
                           std::make_unique<StillLight>(sun),
                           compositor_,
                           options);
    return pipeline.Process(frame).value();
  }

  // Irradiance of the top of a box 0.9 m high, by the composite.
  double OnTop(const Frame& frame, double x_m, double sun = StillLight::kSun) {
    const FrameResult result =
        Process(frame, BoxObject({-0.6f, -0.6f, 0.0f}, {0.6f, 0.6f, 0.9f}, kWhite), sun);
    const glm::dvec2 at = PixelOf(frame.camera, {x_m, 0.0, 0.9});
    const auto x = static_cast<int>(std::lround(at.x));
    const auto y = static_cast<int>(std::lround(at.y));
    return result.composite.radiance.At(x, y).g * std::numbers::pi / kAlbedo;
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

TEST_F(SeenShade, TakesNothingFromTheSky) {
  const Frame frame = WithFactor([](const glm::dvec3&) { return kShaded / kLit; });
  EXPECT_NEAR(OnTop(frame, 0.3, 0.0), kShaded, 0.03 * kShaded) << "no sun";
  EXPECT_NEAR(OnTop(frame, 0.3), kShaded, 0.03 * kShaded) << "all in shade";
}

// Of a ball at the picture's left edge, most of the shadow falls outside.
TEST_F(SeenShade, GoesOnWhereTheShadowIsNotInThePicture) {
  const Frame frame =
      WithFactor([](const glm::dvec3& at_m) { return at_m.x < -1.2 ? kShaded / kLit : 1.0; });
  const VirtualObject ball = BallObject({-1.7f, 0.0f, 0.8f}, 0.8f, 24, kWhite);
  const auto brightest = [&](const Frame& of) {
    const FrameResult result = Process(of, ball, StillLight::kSun);
    float value = 0.0f;
    for (std::size_t i = 0; i < result.composite.radiance.pixels.size(); ++i) {
      if (result.composite.change.pixels[i] == static_cast<std::uint8_t>(PixelChange::kCovered)) {
        value = std::max(value, result.composite.radiance.pixels[i].g);
      }
    }
    return value * std::numbers::pi / kAlbedo;
  };
  // Facing the sun it has all of it, and light from the ground; in the shade there is no more than
  // what comes from all around.
  EXPECT_GT(brightest(stage_.MakeFrame()), StillLight::kSun);
  EXPECT_LT(brightest(frame), 0.6 * StillLight::kSun);
}

}  // namespace
}  // namespace pleinair::seen_shade_test

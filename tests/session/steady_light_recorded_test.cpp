// The light of a scene that stands still, estimated from a camera that does not.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "session/sequence_site.h"

namespace pleinair::steady_light_recorded_test {
namespace {

constexpr int kFrames = 90;
constexpr auto kFrameTime = std::chrono::milliseconds(33);

glm::vec3 Bilinear(const RgbImage& image, double x, double y) {
  const int left = static_cast<int>(std::floor(x));
  const int top = static_cast<int>(std::floor(y));
  const auto u = static_cast<float>(x - left);
  const auto v = static_cast<float>(y - top);
  return (1.0f - v) * ((1.0f - u) * image.At(left, top) + u * image.At(left + 1, top)) +
         v * ((1.0f - u) * image.At(left, top + 1) + u * image.At(left + 1, top + 1));
}

// Frame `i` of a camera in the hand that looks about within what `recorded` shows: 5 deg to the
// sides and 3 up and down, up to 6 mrad a frame. Light and all that it falls on stand still.
Frame LookingAbout(const Frame& recorded, int i) {
  constexpr int kWidthPx = 320;
  constexpr int kHeightPx = 240;
  constexpr double kYawRad = 5.0 * std::numbers::pi / 180.0;
  constexpr double kPitchRad = 3.0 * std::numbers::pi / 180.0;
  const double turns =
      2.0 * std::numbers::pi * std::chrono::duration<double>(i * kFrameTime).count();
  const glm::dmat4 turn =
      glm::rotate(glm::dmat4(1.0), kYawRad * std::sin(turns / 3.0), glm::dvec3(0.0, 1.0, 0.0)) *
      glm::rotate(glm::dmat4(1.0), kPitchRad * std::sin(turns / 2.3), glm::dvec3(1.0, 0.0, 0.0));
  Frame frame = recorded;
  frame.index = i;
  frame.time = recorded.time + i * kFrameTime;
  const CameraIntrinsics& lens = recorded.camera.intrinsics;
  CameraIntrinsics& own = frame.camera.intrinsics;
  own.width_px = kWidthPx;
  own.height_px = kHeightPx;
  own.cx_px = 0.5 * (kWidthPx - 1);
  own.cy_px = 0.5 * (kHeightPx - 1);
  frame.camera.camera_from_world = turn * recorded.camera.camera_from_world;
  const glm::dmat3 recorded_from_own = glm::transpose(glm::dmat3(turn));
  frame.radiance = RgbImage(kWidthPx, kHeightPx);
  for (int y = 0; y < kHeightPx; ++y) {
    for (int x = 0; x < kWidthPx; ++x) {
      const glm::dvec3 ray =
          recorded_from_own *
          glm::dvec3((x - own.cx_px) / own.fx_px, (y - own.cy_px) / own.fy_px, 1.0);
      frame.radiance.At(x, y) = Bilinear(recorded.radiance,
                                         lens.cx_px + lens.fx_px * ray.x / ray.z,
                                         lens.cy_px + lens.fy_px * ray.y / ray.z);
    }
  }
  frame.clipped = Gray8Image(kWidthPx, kHeightPx, 0);
  frame.unusable = Gray8Image(kWidthPx, kHeightPx, 0);
  return frame;
}

// As a jerk of the camera blurs it: over a twelfth of its width.
void Blur(RgbImage& picture) {
  const int reach = picture.width / 24;
  const RgbImage sharp = picture;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      glm::vec3 sum(0.0f);
      for (int dx = -reach; dx <= reach; ++dx) {
        sum += sharp.At(std::clamp(x + dx, 0, picture.width - 1), y);
      }
      picture.At(x, y) = sum / static_cast<float>(2 * reach + 1);
    }
  }
}

// As a tracker that loses its markers for a moment poses it: by `turn_rad` off.
void PoseBadly(double turn_rad, Frame& frame) {
  glm::dmat4& pose = frame.camera.camera_from_world;
  pose = glm::rotate(glm::dmat4(1.0), turn_rad, glm::dvec3(0.6, 0.8, 0.0)) * pose;
}

// Largest change from one frame to the next, and rms about the mean: shares.
struct Flicker {
  double largest_step = 0.0;
  double rms = 0.0;
};

Flicker FlickerOf(const std::vector<double>& values) {
  double mean = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  Flicker flicker;
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += (values[i] / mean - 1.0) * (values[i] / mean - 1.0);
    if (i == 0) continue;
    flicker.largest_step =
        std::max(flicker.largest_step, std::abs(values[i] / values[i - 1] - 1.0));
  }
  flicker.rms = std::sqrt(sum / static_cast<double>(values.size()));
  return flicker;
}

double Mean(const glm::dvec3& rgb) { return (rgb.x + rgb.y + rgb.z) / 3.0; }

class SteadyLight : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const std::filesystem::path folder =
        std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";
    if (std::filesystem::exists(folder)) place_ = std::make_unique<Place>(folder);
  }
  static void TearDownTestSuite() { place_.reset(); }
  void SetUp() override {
    if (!place_) GTEST_SKIP() << "../shared/sequences/courtyard-clouds is not there";
  }

  // Mean sun and sky of each frame, filtered and by itself.
  struct Light {
    std::vector<double> sun;
    std::vector<double> sky;
    std::vector<double> own_sky;
  };
  static Light LightOf(const std::function<void(int, Frame&)>& disturb) {
    const HeadlessContext context;
    Compositor compositor;
    FramePipelineOptions options;
    options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
    FramePipeline pipeline({place_->scene, place_->site.model.mesh, place_->sequence.site, {}},
                           MakeOutdoorLightingSource({}),
                           compositor,
                           options);
    Light light;
    for (int i = 0; i < kFrames; ++i) {
      Frame frame = LookingAbout(place_->recorded, i);
      disturb(i, frame);
      const auto result = pipeline.Process(frame);
      if (!result) throw std::runtime_error(result.error().reason);
      light.sun.push_back(Mean(result->estimate.lighting.sun.irradiance_rgb));
      light.sky.push_back(Mean(result->estimate.lighting.SkyIrradianceRgb()));
      light.own_sky.push_back(Mean(result->raw_lighting.SkyIrradianceRgb()));
    }
    return light;
  }

 private:
  struct Place {
    Sequence sequence;
    SequenceSite site;
    PreparedScene scene;
    Frame recorded;

    explicit Place(const std::filesystem::path& folder)
        : sequence(ReadSequence(folder)), site(LoadSequenceSite(sequence)) {
      PrepareOptions prepare = PrepareOptionsFor(site);
      prepare.gather.rays_per_receiver = 64;
      prepare.probe_counts = {2, 2, 2};
      KeepsNothing store;
      scene = PrepareScene(site.model, prepare, store, [](auto, auto) {});
      const auto frames = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
      for (int i = 0; i <= 6; ++i) recorded = frames->Next()->value();
    }
  };
  static std::unique_ptr<Place> place_;
};
std::unique_ptr<SteadyLight::Place> SteadyLight::place_;

TEST_F(SteadyLight, DoesNotFlickerWhereTheCameraLooksAbout) {
  const Light light = LightOf([](int, Frame&) {});
  const Flicker sun = FlickerOf(light.sun);
  const Flicker sky = FlickerOf(light.sky);
  // A frame by itself changes by more than is not seen: what follows is the filter's work.
  EXPECT_GT(FlickerOf(light.own_sky).largest_step, 0.005);
  EXPECT_LT(sun.largest_step, 0.005);
  EXPECT_LT(sky.largest_step, 0.005);
  // Other walls and stones come into view, with their own errors of albedo.
  EXPECT_LT(sun.rms, 0.005);
  EXPECT_LT(sky.rms, 0.01);
}

// A fifth of a second each: a jerk, then poses that are 1 and 3 degrees off.
TEST_F(SteadyLight, DoesNotFlickerWhereFramesAreBlurredOrBadlyPosed) {
  const Light light = LightOf([](int i, Frame& frame) {
    if (i >= 30 && i < 36) Blur(frame.radiance);
    if (i >= 50 && i < 56) PoseBadly(1.0 * std::numbers::pi / 180.0, frame);
    if (i >= 70 && i < 76) PoseBadly(3.0 * std::numbers::pi / 180.0, frame);
  });
  EXPECT_GT(FlickerOf(light.own_sky).largest_step, 0.02);
  EXPECT_LT(FlickerOf(light.sun).largest_step, 0.005);
  EXPECT_LT(FlickerOf(light.sky).largest_step, 0.01);
}

}  // namespace
}  // namespace pleinair::steady_light_recorded_test

// The light of a scene that stands still, estimated from a camera that does not.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <numbers>
#include <string>
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

TEST(SteadyLight, DoesNotFlickerWhereTheCameraLooksAbout) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Sequence sequence = ReadSequence(folder);
  const SequenceSite site = LoadSequenceSite(sequence);
  PrepareOptions prepare = PrepareOptionsFor(site);
  prepare.gather.rays_per_receiver = 64;
  prepare.probe_counts = {2, 2, 2};
  KeepsNothing store;
  const PreparedScene scene = PrepareScene(site.model, prepare, store, [](auto, auto) {});
  const auto recorded_frames = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
  Frame recorded;
  for (int i = 0; i <= 6; ++i) recorded = recorded_frames->Next()->value();

  const HeadlessContext context;
  Compositor compositor;
  FramePipelineOptions options;
  options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
  FramePipeline pipeline({scene, site.model.mesh, sequence.site, {}},
                         MakeOutdoorLightingSource({}),
                         compositor,
                         options);
  std::array<std::vector<double>, 4> values;  // Sun and sky, and each frame's own.
  for (int i = 0; i < kFrames; ++i) {
    const auto result = pipeline.Process(LookingAbout(recorded, i));
    ASSERT_TRUE(result) << i << ": " << result.error().reason;
    const auto add = [&](std::size_t first, const Lighting& lighting) {
      values[first].push_back(Mean(lighting.sun.irradiance_rgb));
      glm::dvec3 sky(0.0);
      for (const SkyComponent& component : lighting.sky) sky += component.irradiance_rgb;
      values[first + 1].push_back(Mean(sky));
    };
    add(0, result->estimate.lighting);
    add(2, result->raw_lighting);
  }
  const Flicker sun = FlickerOf(values[0]);
  const Flicker sky = FlickerOf(values[1]);
  // A frame by itself changes by more than is not seen: what follows is the filter's work.
  EXPECT_GT(FlickerOf(values[3]).largest_step, 0.005);
  EXPECT_LT(sun.largest_step, 0.005);
  EXPECT_LT(sky.largest_step, 0.005);
  // Other walls and stones come into view, with their own errors of albedo.
  EXPECT_LT(sun.rms, 0.005);
  EXPECT_LT(sky.rms, 0.01);
}

}  // namespace
}  // namespace pleinair::steady_light_recorded_test

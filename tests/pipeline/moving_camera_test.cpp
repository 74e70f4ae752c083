// A camera that moves: only what matters of each view is made.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "estimation/outdoor_lighting_source.h"
#include "ground_stage.h"

namespace pleinair::moving_camera_test {
namespace {

const Material kGrey{.name = "grey", .diffuse_albedo = glm::vec3(0.5f), .specular_reflectance = {}};

// Looks at no pixel, or at any; notes how many of each view show a surface.
class WatchedLight : public StillLight {
 public:
  WatchedLight(bool looks_at_any, std::vector<std::size_t>& shown)
      : looks_at_any_(looks_at_any), shown_(shown) {}

  std::optional<std::vector<PixelRect>> PixelsLookedAt(const Camera&) const override {
    if (looks_at_any_) return std::nullopt;
    return std::vector<PixelRect>();
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    const std::vector<std::int32_t>& region = observation.view.region.pixels;
    shown_.push_back(region.size() -
                     static_cast<std::size_t>(std::ranges::count(region, SurfaceView::kNoRegion)));
    return StillLight::Estimate(observation);
  }

 private:
  bool looks_at_any_;
  std::vector<std::size_t>& shown_;
};

struct Walk {
  std::vector<Composite> composites;
  std::vector<std::size_t> shown;  // Pixels of each view that show a surface.
};

constexpr int kFrames = 6;

FramePipelineOptions OnSurfaces() {
  FramePipelineOptions options = GroundStage::QuickOptions();
  options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
  options.influence_at = InfluenceAt::kFaces;
  options.camera_matching.blur = false;
  return options;
}

// A centimetre and a milliradian a frame, up to frame `stands`. From frame `jumps` on the object is
// elsewhere.
class MovingCamera : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    stage_ =
        std::make_unique<GroundStage>(GroundStage::Block{{1.0f, 1.5f, 0.0f}, {2.0f, 2.5f, 3.0f}});
  }
  static void TearDownTestSuite() { stage_.reset(); }

  static Walk WalkPast(const std::vector<VirtualObject>& objects,
                       const FramePipelineOptions& options,
                       bool looks_at_any,
                       std::optional<int> jumps = std::nullopt,
                       std::optional<int> stands = std::nullopt) {
    const HeadlessContext context;
    Compositor compositor;
    Walk walk;
    FramePipeline pipeline({stage_->Scene(), stage_->Phantom(), std::nullopt, objects},
                           std::make_unique<WatchedLight>(looks_at_any, walk.shown),
                           compositor,
                           options);
    for (int i = 0; i < kFrames; ++i) {
      Frame frame = stage_->MakeFrame();
      frame.index = i;
      frame.time += std::chrono::milliseconds(33 * i);
      const int step = stands && i >= *stands ? *stands : i;
      frame.camera.camera_from_world =
          glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(0.01 * step, 0.0, 0.0)),
                      0.001 * step,
                      glm::dvec3(0.0, 1.0, 0.0)) *
          frame.camera.camera_from_world;
      std::vector<glm::dmat4> poses(objects.size(), glm::dmat4(1.0));
      if (jumps && i >= *jumps) poses[0] = glm::translate(glm::dmat4(1.0), {-0.8, 0.3, 0.0});
      walk.composites.push_back(pipeline.Process(frame, poses).value().composite);
    }
    return walk;
  }

  static void ExpectTheSamePictures(const Walk& a, const Walk& b) {
    for (std::size_t i = 0; i < kFrames; ++i) {
      EXPECT_EQ(a.composites[i].radiance.pixels, b.composites[i].radiance.pixels) << i;
      EXPECT_EQ(a.composites[i].change.pixels, b.composites[i].change.pixels) << i;
    }
  }

  static std::unique_ptr<GroundStage> stage_;
};

std::unique_ptr<GroundStage> MovingCamera::stage_;

std::vector<VirtualObject> SmallBox() {
  return {BoxObject({-0.3f, -0.3f, 0.0f}, {0.0f, 0.0f, 0.3f}, kGrey)};
}

TEST_F(MovingCamera, PicturesAreTheSameFromAPartOfEachView) {
  const Walk whole = WalkPast(SmallBox(), OnSurfaces(), true);
  const Walk part = WalkPast(SmallBox(), OnSurfaces(), false);
  ExpectTheSamePictures(whole, part);
  EXPECT_EQ(part.shown[0], whole.shown[0]) << "nothing is known before the first frame";
  for (std::size_t i = 1; i < kFrames; ++i) {
    EXPECT_GT(part.shown[i], 0u);
    EXPECT_LT(part.shown[i], 3 * whole.shown[i] / 4) << i;
  }
}

TEST_F(MovingCamera, WithoutObjectsOnlySamplesAreLookedAt) {
  const Walk part = WalkPast({}, OnSurfaces(), false);
  for (std::size_t i = 1; i < kFrames; ++i) EXPECT_EQ(part.shown[i], 0u);
}

// Its new place has to be found first.
TEST_F(MovingCamera, AnObjectThatMovesIsSeenInTheWholeView) {
  const Walk whole = WalkPast(SmallBox(), OnSurfaces(), true, 3);
  const Walk part = WalkPast(SmallBox(), OnSurfaces(), false, 3);
  ExpectTheSamePictures(whole, part);
  EXPECT_EQ(part.shown[3], whole.shown[3]);
  EXPECT_LT(part.shown[5], whole.shown[5]);
}

// A repeated pose may be a tracker's: the part stands for some frames.
TEST_F(MovingCamera, ACameraThatStopsSeesTheWholeView) {
  const Walk whole = WalkPast(SmallBox(), OnSurfaces(), true, std::nullopt, 1);
  const Walk part = WalkPast(SmallBox(), OnSurfaces(), false, std::nullopt, 1);
  ExpectTheSamePictures(whole, part);
  for (const std::size_t i : {1, 2, 3, 4}) EXPECT_LT(part.shown[i], whole.shown[i]) << i;
  EXPECT_EQ(part.shown[5], whole.shown[5]);
}

// Its shadow and what it hides are two pixels high.
TEST_F(MovingCamera, ADistantObjectDoesNotBlink) {
  const std::vector<VirtualObject> distant{
      BoxObject({-0.8f, 7.0f, 0.0f}, {-0.5f, 7.2f, 0.2f}, kGrey)};
  const Walk whole = WalkPast(distant, OnSurfaces(), true);
  ExpectTheSamePictures(whole, WalkPast(distant, OnSurfaces(), false));
  for (const Composite& composite : whole.composites) {
    EXPECT_GT(std::ranges::count(composite.change.pixels,
                                 static_cast<std::uint8_t>(PixelChange::kScaled)),
              0);
  }
}

// Mirrors show any part of the view, and a lens's blur is measured at all edges.
TEST_F(MovingCamera, WhatReadsAllOfAViewGetsIt) {
  std::vector<VirtualObject> mirror = SmallBox();
  mirror[0].mesh.materials[0].specular_reflectance = glm::vec3(0.8f);
  const Walk of_mirror = WalkPast(mirror, OnSurfaces(), false);
  FramePipelineOptions blurred = OnSurfaces();
  blurred.camera_matching.blur = true;
  const Walk of_blur = WalkPast(SmallBox(), blurred, false);
  const Walk whole = WalkPast(SmallBox(), OnSurfaces(), true);
  EXPECT_EQ(of_mirror.shown, whole.shown);
  EXPECT_EQ(of_blur.shown, whole.shown);
}

// The light of samples that follow the surfaces; of the whole view, where `looks_at_any`.
class OutdoorLight : public LightingSource {
 public:
  explicit OutdoorLight(bool looks_at_any) : looks_at_any_(looks_at_any) {}

  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                   const SunState& sun) override {
    return source_->BasisFor(frame, sun);
  }
  std::optional<std::vector<PixelRect>> PixelsLookedAt(const Camera& camera) const override {
    return looks_at_any_ ? std::nullopt : source_->PixelsLookedAt(camera);
  }
  bool IsServedBy(const LightingObservation& observation) const override {
    return source_->IsServedBy(observation);
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    return source_->Estimate(observation);
  }
  std::span<const DiffuseSample> Samples() const override { return source_->Samples(); }

 private:
  bool looks_at_any_;
  std::unique_ptr<LightingSource> source_ = MakeOutdoorLightingSource({.samples = 40});
};

struct LightOfWalk {
  std::vector<Lighting> lighting;
  std::vector<std::vector<glm::ivec2>> samples;
};

// A tracker's pose lasts for two frames; in the last frames something covers most of the picture.
LightOfWalk WalkInLight(const GroundStage& stage, bool looks_at_any) {
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline({stage.Scene(), stage.Phantom(), std::nullopt, {}},
                         std::make_unique<OutdoorLight>(looks_at_any),
                         compositor,
                         OnSurfaces());
  LightOfWalk walk;
  for (int i = 0; i < 16; ++i) {
    Frame frame = stage.MakeFrame();
    frame.index = i;
    frame.time += std::chrono::milliseconds(33 * i);
    frame.camera.camera_from_world =
        glm::translate(glm::dmat4(1.0), glm::dvec3(0.01 * (i / 2), 0.0, 0.0)) *
        frame.camera.camera_from_world;
    if (i >= 12) {
      for (int y = 0; y < frame.unusable.height; ++y) {
        for (int x = 0; x < 60; ++x) frame.unusable.At(x, y) = kUnusable;
      }
    }
    walk.lighting.push_back(pipeline.Process(frame).value().estimate.lighting);
    walk.samples.emplace_back();
    for (const DiffuseSample& sample : pipeline.Samples()) {
      walk.samples.back().push_back(sample.pixel);
    }
    if (i == 8) pipeline.WholeView();
  }
  return walk;
}

TEST_F(MovingCamera, TheLightIsTheSameFromAPartOfEachView) {
  const LightOfWalk whole = WalkInLight(*stage_, true);
  const LightOfWalk part = WalkInLight(*stage_, false);
  for (std::size_t i = 0; i < whole.lighting.size(); ++i) {
    EXPECT_EQ(part.samples[i], whole.samples[i]) << i;
    EXPECT_EQ(part.lighting[i].sun.irradiance_rgb, whole.lighting[i].sun.irradiance_rgb) << i;
    EXPECT_EQ(part.lighting[i].sky[0].irradiance_rgb, whole.lighting[i].sky[0].irradiance_rgb) << i;
  }
  EXPECT_FALSE(whole.samples.back().empty());
}

}  // namespace
}  // namespace pleinair::moving_camera_test

// The effect plan held to its word on a level ground: under sun, cloud and no light at all, with
// the object in the shade, and out of sight.
#include "planned_frames.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "ground_stage.h"

namespace pleinair::planned_frames_test {
namespace {

const Material kRed{
    .name = "red", .diffuse_albedo = {0.6f, 0.1f, 0.1f}, .specular_reflectance = {}};
const Material kMirror{.name = "mirror",
                       .diffuse_albedo = glm::vec3(0.1f),
                       .specular_reflectance = glm::vec3(0.6f),
                       .roughness = 0.3f};

constexpr EffectSet kSky{Effect::kProbeShading, Effect::kSkyOcclusion, Effect::kColourBleeding};
constexpr EffectSet kSkyAndSun{Effect::kProbeShading,
                               Effect::kSkyOcclusion,
                               Effect::kColourBleeding,
                               Effect::kSunShading,
                               Effect::kSunShadow,
                               Effect::kObjectShadow,
                               Effect::kPenumbra};

struct StagedFrame {
  const char* name;
  bool has_wall = false;
  double sun = StillLight::kSun;
  double sky = StillLight::kSky;
  glm::dvec3 object_at_m{0.0};
  double object_size = 1.0;
  EffectSet called_for{};
  Material material = kRed;
};

const StagedFrame kSunny{.name = "sunny", .called_for = kSkyAndSun};
const StagedFrame kOvercast{.name = "overcast", .sun = 0.0, .called_for = kSky};
const StagedFrame kNight{.name = "night", .sun = 0.0, .sky = 0.0};
// Behind the camera, and so is its shadow.
const StagedFrame kOutOfSight{.name = "out of sight", .object_at_m = {0.0, -40.0, 0.0}};
const StagedFrame kInTheShade{.name = "in the shade", .has_wall = true, .called_for = kSky};
// A box of 6 mm, 0.3 m before the camera: far from all that could be darkened.
const StagedFrame kFarFromSurfaces{
    .name = "far from surfaces",
    .object_at_m = {0.0, -4.94, 2.85},
    .object_size = 0.01,
    .called_for = {
        Effect::kProbeShading, Effect::kSunShading, Effect::kObjectShadow, Effect::kPenumbra}};
const StagedFrame kGlossy{
    .name = "glossy",
    .called_for = EffectSet::FromBits(kSkyAndSun.With(Effect::kGlossyReflection).Bits()),
    .material = kMirror};

class PlannedFrames : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    open_ = std::make_unique<GroundStage>();
    walled_ = std::make_unique<GroundStage>(true);
  }
  static void TearDownTestSuite() {
    open_.reset();
    walled_.reset();
  }

  static FramePipeline PipelineFor(const StagedFrame& staged, Compositor& compositor) {
    const GroundStage& stage = staged.has_wall ? *walled_ : *open_;
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.influence.rays_per_receiver = 16;
    return FramePipeline(stage.Scene(),
                         stage.Phantom(),
                         std::nullopt,
                         {BoxObject({-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.8f}, staged.material)},
                         std::make_unique<StillLight>(staged.sun, staged.sky),
                         compositor,
                         options);
  }
  // Exposed for open ground under sun and sky.
  static Frame FrameOf(const StagedFrame& staged) {
    Frame frame = open_->MakeFrame(staged.sun, staged.sky);
    if (staged.has_wall) frame = open_->MakeFrame(0.0, staged.sky);
    frame.exposure = 0.01;
    return frame;
  }
  static std::vector<glm::dmat4> PoseOf(const StagedFrame& staged) {
    return {glm::scale(glm::translate(glm::dmat4(1.0), staged.object_at_m),
                       glm::dvec3(staged.object_size))};
  }

  static std::unique_ptr<GroundStage> open_;
  static std::unique_ptr<GroundStage> walled_;
};

std::unique_ptr<GroundStage> PlannedFrames::open_;
std::unique_ptr<GroundStage> PlannedFrames::walled_;

TEST_F(PlannedFrames, RunWhatTheyCallForAndLookAsWithEverything) {
  const HeadlessContext context;
  Compositor compositor;
  std::map<std::string, int> draw_calls;
  for (const StagedFrame& staged :
       {kSunny, kOvercast, kNight, kOutOfSight, kInTheShade, kFarFromSurfaces, kGlossy}) {
    FramePipeline pipeline = PipelineFor(staged, compositor);
    const FrameResult planned =
        ExpectThatBoundsHold(pipeline, FrameOf(staged), staged.name, PoseOf(staged));
    EXPECT_EQ(planned.plan.runs.Bits(), staged.called_for.Bits()) << staged.name;
    draw_calls[staged.name] = planned.composite.draw_calls;
  }
  EXPECT_LT(draw_calls["overcast"], draw_calls["sunny"]);
  EXPECT_EQ(draw_calls["in the shade"], draw_calls["overcast"]);
  EXPECT_LT(draw_calls["far from surfaces"], draw_calls["sunny"]);
  EXPECT_LT(draw_calls["night"], draw_calls["overcast"]);
  EXPECT_EQ(draw_calls["out of sight"], 0);
}

TEST_F(PlannedFrames, AStillFrameKeepsTheLastOnesWork) {
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline = PipelineFor(kSunny, compositor);
  const Frame frame = FrameOf(kSunny);
  const FrameResult first = pipeline.Process(frame).value();
  const FrameResult second = pipeline.Process(frame).value();
  EXPECT_EQ(first.composite.radiance.pixels, second.composite.radiance.pixels);
  for (const Effect effect : {Effect::kSunShadow,
                              Effect::kObjectShadow,
                              Effect::kPenumbra,
                              Effect::kProbeShading,
                              Effect::kSkyOcclusion,
                              Effect::kColourBleeding}) {
    EXPECT_EQ(first.plan.Of(effect).fate, EffectFate::kRun) << NameOf(effect);
    EXPECT_EQ(second.plan.Of(effect).fate, EffectFate::kKept) << NameOf(effect);
  }
}

// An effect that sat out while the object moved is that of a pipeline which never left it out.
TEST_F(PlannedFrames, WhatWasLeftOutIsMadeWhenItIsWanted) {
  const HeadlessContext context;
  Compositor compositor;
  const Frame frame = FrameOf(kGlossy);
  const std::vector<glm::dmat4> moved{glm::translate(glm::dmat4(1.0), glm::dvec3(0.2, 0.1, 0.0))};
  FramePipeline fresh = PipelineFor(kGlossy, compositor);
  const FrameResult expected = ProcessWith(fresh, frame, EffectSettings::Everything(), moved);
  FramePipeline pipeline = PipelineFor(kGlossy, compositor);
  ProcessWith(pipeline, frame, EffectSettings::Everything());
  EffectSettings none;
  none.switches = EffectSettings::Filled(EffectSwitch::kOff);
  ProcessWith(pipeline, frame, none, moved);
  const FrameResult found = ProcessWith(pipeline, frame, EffectSettings::Everything(), moved);
  EXPECT_EQ(found.composite.radiance.pixels, expected.composite.radiance.pixels);
}

TEST_F(PlannedFrames, ABudgetTellsWhatItCost) {
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline = PipelineFor(kSunny, compositor);
  EffectSettings settings;
  settings.budget_ms = 1e-3;
  const FrameResult poor = ProcessWith(pipeline, FrameOf(kSunny), settings);
  EXPECT_TRUE(poor.plan.runs.Empty());
  EXPECT_FALSE(poor.plan.fits_budget);
  EXPECT_GT(poor.plan.left_out_code_values, 100.0);
  settings.budget_ms = 1e6;
  const FrameResult rich = ProcessWith(pipeline, FrameOf(kSunny), settings);
  EXPECT_EQ(rich.plan.runs, kSkyAndSun);
  EXPECT_EQ(rich.plan.left_out_code_values, 0.0);
}

// Casting the rays around the object takes more than the budget, what hangs on them in later frames
// does not: once the view stands still it is begun.
TEST_F(PlannedFrames, ABudgetBeginsWhatLaterFramesCanAfford) {
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline = PipelineFor(kSunny, compositor);
  EffectSettings settings;
  settings.budget_ms = 100.0;  // The guesses are 150 ms once, and 10 ms for each of two lights.
  const FrameResult first = ProcessWith(pipeline, FrameOf(kSunny), settings);
  EXPECT_FALSE(first.plan.runs.Has(Effect::kProbeShading));
  const FrameResult second = ProcessWith(pipeline, FrameOf(kSunny), settings);
  EXPECT_TRUE(second.plan.runs.Has(Effect::kProbeShading));
}

}  // namespace
}  // namespace pleinair::planned_frames_test

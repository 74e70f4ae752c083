// The effect plan held to its word on a level ground: under sun, cloud and no light at all, with
// the object in the shade, and out of sight.
#include "planned_frames.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "ground_stage.h"
#include "scene/stopwatch.h"
#include "tests/render/textured_meshes.h"

namespace pleinair::planned_frames_test {
namespace {

const Material kRed{
    .name = "red", .diffuse_albedo = {0.6f, 0.1f, 0.1f}, .specular_reflectance = {}};
const Material kMirror{.name = "mirror",
                       .diffuse_albedo = glm::vec3(0.1f),
                       .specular_reflectance = glm::vec3(0.6f),
                       .roughness = 0.3f};

constexpr EffectSet kSky{Effect::kProbeShading, Effect::kSkyOcclusion, Effect::kColourBleeding};
// The sun shines, and on the ground beside the object.
constexpr EffectSet kSkyBesideAWall =
    kSky.With(Effect::kLocalLight).With(Effect::kAmbientOcclusion);
// In an open field: light on the object is the same all over it but for which way it faces.
constexpr EffectSet kSkyAndSun{Effect::kProbeShading,
                               Effect::kAmbientOcclusion,
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
const StagedFrame kInTheShade{
    .name = "in the shade", .has_wall = true, .called_for = kSkyBesideAWall};
// A box of 6 mm, 0.3 m before the camera: far from all that could be darkened.
const StagedFrame kFarFromSurfaces{.name = "far from surfaces",
                                   .object_at_m = {0.0, -4.94, 2.85},
                                   .object_size = 0.01,
                                   .called_for = {Effect::kProbeShading,
                                                  Effect::kAmbientOcclusion,
                                                  Effect::kSunShading,
                                                  Effect::kObjectShadow,
                                                  Effect::kPenumbra}};
const StagedFrame kGlossy{
    .name = "glossy",
    .called_for = EffectSet::FromBits(kSkyAndSun.With(Effect::kGlossyReflection).Bits()),
    .material = kMirror};

Frame AtNoon(Frame frame) {
  frame.time += std::chrono::hours(3);
  frame.sun_direction_enu = glm::normalize(glm::dvec3(0.1, -0.3, 0.9));
  return frame;
}

class PlannedFrames : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    open_stage = std::make_unique<GroundStage>();
    walled_stage = std::make_unique<GroundStage>(true);
  }
  static void TearDownTestSuite() {
    open_stage.reset();
    walled_stage.reset();
  }

  static FramePipeline PipelineFor(const StagedFrame& staged, Compositor& compositor) {
    return PipelineFor(staged,
                       BoxObject({-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.8f}, staged.material),
                       ObjectLight::kGather,
                       compositor);
  }
  static FramePipeline PipelineFor(const StagedFrame& staged,
                                   const VirtualObject& object,
                                   ObjectLight object_light,
                                   Compositor& compositor) {
    const GroundStage& stage = staged.has_wall ? *walled_stage : *open_stage;
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.influence.rays_per_receiver = 16;
    // Noise of rays is no effect: it is far below a code value.
    options.object_light.gather.rays_per_receiver =
        object.mesh.positions_m.size() > 100 ? 1024 : 4096;
    options.object_light.route = object_light;
    return FramePipeline({stage.Scene(), stage.Phantom(), std::nullopt, {object}},
                         std::make_unique<StillLight>(staged.sun, staged.sky),
                         compositor,
                         options);
  }
  // Exposed for open ground under sun and sky.
  static Frame FrameOf(const StagedFrame& staged) {
    Frame frame = open_stage->MakeFrame(staged.sun, staged.sky);
    if (staged.has_wall) frame = open_stage->MakeFrame(0.0, staged.sky);
    frame.exposure = 0.01;
    return frame;
  }
  static std::vector<glm::dmat4> PoseOf(const StagedFrame& staged) {
    return {glm::scale(glm::translate(glm::dmat4(1.0), staged.object_at_m),
                       glm::dvec3(staged.object_size))};
  }

  static std::unique_ptr<GroundStage> open_stage;
  static std::unique_ptr<GroundStage> walled_stage;

 private:
  // A budget counts by first guesses, not by what a busy machine takes.
  StoppedTime stopped_time_;
};

std::unique_ptr<GroundStage> PlannedFrames::open_stage;
std::unique_ptr<GroundStage> PlannedFrames::walled_stage;

TEST_F(PlannedFrames, RunWhatTheyCallForAndLookAsWithEverything) {
  const HeadlessContext context;
  Compositor compositor;
  std::map<std::string, int> draw_calls;
  for (const StagedFrame& staged :
       {kSunny, kOvercast, kNight, kOutOfSight, kInTheShade, kFarFromSurfaces, kGlossy}) {
    FramePipeline pipeline = PipelineFor(staged, compositor);
    const FrameResult planned =
        ExpectThatBoundsHold(pipeline, FrameOf(staged), staged.name, PoseOf(staged));
    // What another choice has left to be kept costs nothing: a pipeline of its own.
    FramePipeline fresh = PipelineFor(staged, compositor);
    const FrameResult first = ProcessWith(fresh, FrameOf(staged), EffectSettings(), PoseOf(staged));
    EXPECT_EQ(first.plan.runs.Bits(), staged.called_for.Bits()) << staged.name;
    // The first frame of a view may draw what later ones keep.
    const FrameResult next = ProcessWith(fresh, FrameOf(staged), EffectSettings(), PoseOf(staged));
    EXPECT_EQ(next.composite.draw_calls, planned.composite.draw_calls) << staged.name;
    draw_calls[staged.name] = next.composite.draw_calls;
  }
  EXPECT_LT(draw_calls["overcast"], draw_calls["sunny"]);
  EXPECT_EQ(draw_calls["in the shade"], draw_calls["overcast"]);
  EXPECT_LT(draw_calls["far from surfaces"], draw_calls["sunny"]);
  EXPECT_LT(draw_calls["night"], draw_calls["overcast"]);
  EXPECT_EQ(draw_calls["out of sight"], 0);
}

// In what the object darkens anyway, a step of light is more codes.
TEST_F(PlannedFrames, BoundsHoldUnderAWeakSun) {
  const HeadlessContext context;
  Compositor compositor;
  for (const double sun : {0.5, 3.0, 10.0}) {
    StagedFrame staged = kSunny;
    staged.sun = sun;
    FramePipeline pipeline = PipelineFor(staged, compositor);
    ExpectThatBoundsHold(
        pipeline, FrameOf(staged), "sun of " + std::to_string(sun), PoseOf(staged));
  }
}

// A face is nearly black in the mean: what its few white texels show of the light counts, however
// weak the sun is.
TEST_F(PlannedFrames, BoundsAreThoseOfATexturesBrightestPlaces) {
  Texture::Codes codes(16, 16, glm::u8vec4(25, 25, 25, 255));
  codes.At(5, 5) = codes.At(6, 5) = codes.At(5, 6) = codes.At(6, 6) = glm::u8vec4(255);
  const auto painted = test::Painted(std::move(codes));
  VirtualObject box = BoxObject({-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.8f}, kRed);
  box.mesh = test::Textured(std::move(box.mesh), painted, [](const glm::vec3& p) {
    return 3.0f * glm::vec2(p.x + p.y, p.z);
  });
  const HeadlessContext context;
  Compositor compositor;
  for (const double sun : {0.3, 1.0, 30.0, 400.0}) {
    StagedFrame staged = kSunny;
    staged.sun = sun;
    FramePipeline pipeline = PipelineFor(staged, box, ObjectLight::kGather, compositor);
    ExpectThatBoundsHold(
        pipeline, FrameOf(staged), "sun of " + std::to_string(sun), PoseOf(staged));
  }
}

// A ball on open ground under sky and sun: a single probe suffices for all its vertices and
// looks the same. Its own shadow on the ground, seen by its foot, still differs by vertex.
TEST_F(PlannedFrames, InAnOpenFieldASingleProbeIsUsed) {
  const HeadlessContext context;
  Compositor compositor;
  const VirtualObject ball = BallObject({0.0f, 0.0f, 0.4f}, 0.4f, 24, kRed);
  std::map<std::string, int> draw_calls;
  for (const StagedFrame& staged : {kSunny, kOvercast}) {
    FramePipeline pipeline = PipelineFor(staged, ball, ObjectLight::kGather, compositor);
    const Frame frame = FrameOf(staged);
    const FrameResult planned = ProcessWith(pipeline, frame, EffectSettings());
    const FrameResult all = ProcessWith(pipeline, frame, EffectSettings::Everything());
    for (const PlannedWork& work : all.works) {
      if (work.name == "influence on surfaces") {
        EXPECT_FALSE(work.is_kept)
            << "what the ball reflects depends on where its light was computed";
      }
    }
    EXPECT_EQ(planned.plan.runs.Bits(), staged.called_for.Bits()) << staged.name;
    EXPECT_EQ(planned.plan.Of(Effect::kLocalLight).fate, EffectFate::kLeftOut);
    EXPECT_GT(planned.plan.Of(Effect::kLocalLight).bound_code_values, 0.0);
    // Under a grey sky the ball's effect on its own light is not visible.
    const std::string_view expected = staged.called_for.Has(Effect::kAmbientOcclusion)
                                          ? "light at a single probe"
                                          : "light at a single probe, without objects";
    for (const PlannedWork& work : planned.works) {
      if (work.name.starts_with("light at ")) {
        EXPECT_EQ(work.is_done, work.name == expected) << work.name << staged.name;
      }
    }
    // The first frame of a view may draw what later ones keep.
    const FrameResult again = ProcessWith(pipeline, frame, EffectSettings());
    EXPECT_LE(again.composite.draw_calls, all.composite.draw_calls);
    draw_calls[staged.name] = again.composite.draw_calls;
    ExpectNothingToBeSeenBetween(all, planned, frame, staged.name);

    FramePipeline asked_to = PipelineFor(staged, ball, ObjectLight::kSingleProbe, compositor);
    const FrameResult at_single_probe = ProcessWith(asked_to, frame, EffectSettings());
    EXPECT_TRUE(at_single_probe.composite.radiance.pixels == planned.composite.radiance.pixels);
    EXPECT_EQ(at_single_probe.plan.Of(Effect::kLocalLight).fate, EffectFate::kOff);
  }
  EXPECT_LT(draw_calls["overcast"], draw_calls["sunny"]);
}

// What hides light from itself has rays at its vertices in an open field, too: two boxes whose
// sides see each other.
TEST_F(PlannedFrames, AnObjectThatHidesLightFromItselfIsLitAtItsVertices) {
  const HeadlessContext context;
  Compositor compositor;
  VirtualObject bench = BoxObject({-0.5f, -0.3f, 0.0f}, {0.5f, 0.3f, 0.3f}, kRed);
  AddBox(bench.mesh, {-0.5f, 0.2f, 0.3f}, {0.5f, 0.3f, 0.9f});
  FramePipeline pipeline = PipelineFor(kOvercast, bench, ObjectLight::kGather, compositor);
  const FrameResult planned =
      ExpectThatBoundsHold(pipeline, FrameOf(kOvercast), "a bench under a grey sky");
  EXPECT_TRUE(planned.plan.runs.Has(Effect::kLocalLight));
}

// Exact on a level ground under an even sky: a face that looks up gets the sky, one that stands
// upright half of the sky and half of what the ground sends. 0.3 %: the picture's half floats, and
// 4096 rays of which half have to be above the horizon.
TEST_F(PlannedFrames, LightAtASingleProbeIsTheFieldsOwn) {
  const HeadlessContext context;
  Compositor compositor;
  const VirtualObject box = BoxObject({-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.8f}, kRed);
  FramePipeline pipeline = PipelineFor(kOvercast, box, ObjectLight::kSingleProbe, compositor);
  const Frame frame = FrameOf(kOvercast);
  const FrameResult result = ProcessWith(pipeline, frame, EffectSettings::Everything());
  const auto radiance_at = [&](const glm::dvec3& place_m) {
    const glm::dvec3 at(frame.camera.camera_from_world * glm::dvec4(place_m, 1.0));
    const CameraIntrinsics& lens = frame.camera.intrinsics;
    return result.composite.radiance.At(
        static_cast<int>(std::lround(lens.fx_px * at.x / at.z + lens.cx_px)),
        static_cast<int>(std::lround(lens.fy_px * at.y / at.z + lens.cy_px)));
  };
  const double of_irradiance = 0.6 * std::numbers::inv_pi;
  const double top = of_irradiance * StillLight::kSky;
  const double side = top * (0.5 + 0.5 * GroundStage::kAlbedo);
  EXPECT_NEAR(radiance_at({0.0, 0.0, 0.8}).r, top, 0.003 * top);
  EXPECT_NEAR(radiance_at({0.0, -0.3, 0.4}).r, side, 0.003 * side);
}

TEST(FramePipelineOptions, RefuseStepsThatCannotBeCounted) {
  for (const double step_s : {0.0, 1e-3, 48.0, 86400.0}) {
    FramePipelineOptions options;
    options.sun_step_s = options.bounce_step_s = step_s;
    EXPECT_NO_THROW(options.Validate()) << step_s;
  }
  for (const double step_s : {-1.0, 1e-10, 1e10, std::numeric_limits<double>::quiet_NaN()}) {
    FramePipelineOptions options;
    options.sun_step_s = step_s;
    EXPECT_THROW(options.Validate(), std::invalid_argument) << step_s;
    options = {};
    options.bounce_step_s = step_s;
    EXPECT_THROW(options.Validate(), std::invalid_argument) << step_s;
  }
}

TEST(SingleProbeOptions, RefuseWhatMakesNoSense) {
  const auto refused = [](const auto& spoil) {
    FramePipelineOptions options;
    options.object_light.route = ObjectLight::kSingleProbe;
    options.Validate();
    spoil(options);
    EXPECT_THROW(options.Validate(), std::invalid_argument);
  };
  refused([](FramePipelineOptions& options) { options.object_light.single_probe.rays = 0; });
  refused([](FramePipelineOptions& options) { options.object_light.single_probe.sh_bands = 0; });
  refused([](FramePipelineOptions& options) {
    options.object_light.single_probe.sh_bands = SingleProbeOptions::kMostShBands + 1;
  });
  refused(
      [](FramePipelineOptions& options) { options.object_light.daylight = Daylight::kSamples; });
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
                              Effect::kProbeShading,
                              Effect::kSkyOcclusion,
                              Effect::kColourBleeding}) {
    EXPECT_EQ(first.plan.Of(effect).fate, EffectFate::kRun) << NameOf(effect);
    EXPECT_EQ(second.plan.Of(effect).fate, EffectFate::kKept) << NameOf(effect);
  }
  // Shade that the mesh does not cast is looked for in each picture.
  for (const Effect effect : {Effect::kObjectShadow, Effect::kPenumbra}) {
    EXPECT_EQ(second.plan.Of(effect).fate, EffectFate::kRun) << NameOf(effect);
  }
  for (const PlannedWork& work : second.works) {
    if (work.is_done && !work.is_drawing) {
      EXPECT_EQ(work.is_kept, work.name != "seen shade on objects") << work.name;
    }
  }
}

// An effect that was left out while the object moved equals that of a pipeline which always ran it.
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

TEST_F(PlannedFrames, ABudgetReportsWhatItCost) {
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline = PipelineFor(kSunny, compositor);
  EffectSettings settings;
  settings.budget_ms = 1e-3;
  const FrameResult poor = ProcessWith(pipeline, FrameOf(kSunny), settings);
  // What lights the object, and no more.
  EXPECT_EQ(poor.plan.runs, (EffectSet{Effect::kSunShading, Effect::kProbeShading}));
  EXPECT_FALSE(poor.plan.fits_budget);
  EXPECT_GT(poor.plan.left_out_code_values, 100.0);
  settings.budget_ms = 1e6;
  const FrameResult rich = ProcessWith(pipeline, FrameOf(kSunny), settings);
  EXPECT_EQ(rich.plan.runs, kSkyAndSun.With(Effect::kLocalLight));
  EXPECT_EQ(rich.plan.left_out_code_values, 0.0);
}

// Casting the rays around the object takes more than the budget, what depends on them in later
// frames does not: it is begun, as the view may stand still, and not where the object moves.
TEST_F(PlannedFrames, ABudgetBeginsWhatLaterFramesCanAfford) {
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline = PipelineFor(kSunny, compositor);
  EffectSettings settings;
  settings.budget_ms = 100.0;  // The guesses are 150 ms once, and 10 ms for each of two lights.
  const Frame frame = FrameOf(kSunny);
  const FrameResult first = ProcessWith(pipeline, frame, settings);
  EXPECT_TRUE(first.plan.runs.Has(Effect::kSkyOcclusion));
  FramePipeline of_moving = PipelineFor(kSunny, compositor);
  const std::vector<glm::dmat4> moved{glm::translate(glm::dmat4(1.0), glm::dvec3(0.2, 0.1, 0.0))};
  settings.budget_ms = 1e-3;
  ProcessWith(of_moving, frame, settings);
  settings.budget_ms = 100.0;
  const FrameResult moving = ProcessWith(of_moving, frame, settings, moved);
  EXPECT_FALSE(moving.plan.runs.Has(Effect::kSkyOcclusion));
}

// What light on an object is cheapest under a budget: it stands in the sky's and the sun's light,
// but hides neither from itself.
TEST_F(PlannedFrames, AmbientOcclusionIsAnEffectOfItsOwn) {
  const HeadlessContext context;
  Compositor compositor;
  VirtualObject bench = BoxObject({-0.5f, -0.3f, 0.0f}, {0.5f, 0.3f, 0.3f}, kRed);
  AddBox(bench.mesh, {-0.5f, 0.2f, 0.3f}, {0.5f, 0.3f, 0.9f});
  EffectSettings without = EffectSettings::Everything();
  without[Effect::kAmbientOcclusion] = EffectSwitch::kOff;
  EffectSettings dark = without;
  dark[Effect::kProbeShading] = EffectSwitch::kOff;
  for (const ObjectLight light : {ObjectLight::kSingleProbe, ObjectLight::kVolume}) {
    FramePipeline pipeline = PipelineFor(kOvercast, bench, light, compositor);
    const Frame frame = FrameOf(kOvercast);
    const DisplayCodes codes(ResponseCurve::Srgb(), frame.exposure.value());
    const FrameResult all = ProcessWith(pipeline, frame, EffectSettings::Everything());
    const FrameResult open = ProcessWith(pipeline, frame, without);
    const auto largest = [&](const FrameResult& result) {
      const std::vector<float> change = Differences(all.composite, result.composite, codes);
      return *std::max_element(change.begin(), change.end());
    };
    EXPECT_GT(largest(open), 5.0f) << "the corner between seat and back";
    EXPECT_LT(largest(open), 0.6f * largest(ProcessWith(pipeline, frame, dark)));
    EXPECT_EQ(ProcessWith(pipeline, frame, EffectSettings::Everything()).composite.radiance.pixels,
              all.composite.radiance.pixels);
    // Rays at vertices meet the object in any case.
    FramePipeline gathers = PipelineFor(kOvercast, bench, ObjectLight::kGather, compositor);
    const FrameResult at_vertices = ProcessWith(gathers, frame, EffectSettings::Everything());
    EXPECT_EQ(ProcessWith(gathers, frame, without).composite.radiance.pixels,
              at_vertices.composite.radiance.pixels);
  }
}

// What a budget falls back to under a new sun: on the object and in it as a mirror.
TEST_F(PlannedFrames, LightOfAnOlderSunStandsInUntilItsOwnIsMade) {
  const HeadlessContext context;
  Compositor compositor;
  const Frame morning = FrameOf(kGlossy);
  const Frame noon = AtNoon(morning);

  FramePipeline fresh = PipelineFor(kGlossy, compositor);
  const FrameResult expected = ProcessWith(fresh, noon, EffectSettings());
  EXPECT_EQ(expected.plan.Of(Effect::kLightUpdate).bound_code_values, 0.0);
  EffectSettings dark;
  dark[Effect::kProbeShading] = dark[Effect::kGlossyReflection] = EffectSwitch::kOff;
  const FrameResult without = ProcessWith(fresh, noon, dark);

  FramePipeline pipeline = PipelineFor(kGlossy, compositor);
  ProcessWith(pipeline, morning, EffectSettings());
  EffectSettings older;
  older[Effect::kLightUpdate] = EffectSwitch::kOff;
  const FrameResult stands_in = ProcessWith(pipeline, noon, older);
  const DisplayCodes codes(ResponseCurve::Srgb(), noon.exposure.value());
  const auto largest = [&](const FrameResult& result) {
    const std::vector<float> change = Differences(expected.composite, result.composite, codes);
    return *std::max_element(change.begin(), change.end());
  };
  EXPECT_GT(largest(stands_in), 1.0f);
  EXPECT_LT(largest(stands_in), 0.3f * largest(without));

  // And is made in the end, by whoever asks for it.
  const FrameResult made = ProcessWith(pipeline, noon, EffectSettings());
  EXPECT_EQ(made.plan.Of(Effect::kLightUpdate).fate, EffectFate::kRun);
  EXPECT_EQ(made.composite.radiance.pixels, expected.composite.radiance.pixels);
  EXPECT_EQ(ProcessWith(pipeline, noon, EffectSettings()).plan.Of(Effect::kLightUpdate).fate,
            EffectFate::kLeftOut);
}

// A mirror that showed an object in older light shows it again, also where that was made current in
// a frame without mirrors.
TEST_F(PlannedFrames, MirrorsFollowTheLightOfWhatTheyShow) {
  const HeadlessContext context;
  Compositor compositor;
  VirtualObject pair = BoxObject({-0.6f, -0.3f, 0.0f}, {-0.1f, 0.3f, 0.8f}, kMirror);
  AddBox(pair.mesh, {0.1f, -0.3f, 0.0f}, {0.6f, 0.3f, 0.8f});
  const Frame noon = AtNoon(FrameOf(kGlossy));
  EffectSettings older = EffectSettings::Everything();
  older[Effect::kLightUpdate] = EffectSwitch::kOff;
  EffectSettings matt = EffectSettings::Everything();
  matt[Effect::kGlossyReflection] = EffectSwitch::kOff;
  FramePipeline pipeline = PipelineFor(kGlossy, pair, ObjectLight::kGather, compositor);
  ProcessWith(pipeline, FrameOf(kGlossy), matt);
  ProcessWith(pipeline, noon, older);
  ProcessWith(pipeline, noon, matt);
  const FrameResult found = ProcessWith(pipeline, noon, EffectSettings());
  FramePipeline fresh = PipelineFor(kGlossy, pair, ObjectLight::kGather, compositor);
  const FrameResult expected = ProcessWith(fresh, noon, EffectSettings());
  EXPECT_EQ(found.composite.radiance.pixels, expected.composite.radiance.pixels);
}

// What it does to real surfaces is that of a fresh pipeline, though its own light is not in view.
TEST_F(PlannedFrames, LightOfAnObjectOutOfViewIsOfThisSun) {
  const HeadlessContext context;
  Compositor compositor;
  const Frame morning = FrameOf(kSunny);
  bool found = false;
  for (double aside_m = 2.0; aside_m < 6.0 && !found; aside_m += 0.1) {
    const std::vector<glm::dmat4> pose{
        glm::translate(glm::dmat4(1.0), glm::dvec3(-aside_m, 0.0, 0.0))};
    FramePipeline pipeline = PipelineFor(kSunny, compositor);
    const FrameResult first = ProcessWith(pipeline, morning, EffectSettings(), pose);
    found = first.plan.Of(Effect::kProbeShading).bound_code_values == 0.0 &&
            first.plan.runs.Has(Effect::kColourBleeding);
    if (!found) continue;
    const FrameResult later = ProcessWith(pipeline, AtNoon(morning), EffectSettings(), pose);
    FramePipeline fresh = PipelineFor(kSunny, compositor);
    const FrameResult expected = ProcessWith(fresh, AtNoon(morning), EffectSettings(), pose);
    EXPECT_EQ(later.composite.radiance.pixels, expected.composite.radiance.pixels);
  }
  EXPECT_TRUE(found) << "an object out of view that lights the ground in view";
}

// The influence of older light is computed once, and again when that light is.
TEST_F(PlannedFrames, WhatOlderLightDoesToSurfacesIsKept) {
  const HeadlessContext context;
  Compositor compositor;
  const Frame noon = AtNoon(FrameOf(kSunny));
  const std::vector<glm::dmat4> moved{glm::translate(glm::dmat4(1.0), glm::dvec3(0.2, 0.1, 0.0))};
  EffectSettings older = EffectSettings::Everything();
  older[Effect::kLightUpdate] = EffectSwitch::kOff;
  const VirtualObject box = BoxObject({-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.8f}, kRed);
  for (const ObjectLight light : {ObjectLight::kGather, ObjectLight::kVolume}) {
    FramePipeline pipeline = PipelineFor(kSunny, box, light, compositor);
    ProcessWith(pipeline, FrameOf(kSunny), EffectSettings::Everything(), moved);
    ProcessWith(pipeline, noon, older, moved);
    const FrameResult again = ProcessWith(pipeline, noon, older, moved);
    for (const PlannedWork& work : again.works) {
      if (work.name == "influence on surfaces") {
        EXPECT_TRUE(work.is_kept);
      }
    }
    const FrameResult made = ProcessWith(pipeline, noon, EffectSettings::Everything(), moved);
    FramePipeline fresh = PipelineFor(kSunny, box, light, compositor);
    const FrameResult expected = ProcessWith(fresh, noon, EffectSettings::Everything(), moved);
    EXPECT_EQ(made.composite.radiance.pixels, expected.composite.radiance.pixels);
  }
}

}  // namespace
}  // namespace pleinair::planned_frames_test

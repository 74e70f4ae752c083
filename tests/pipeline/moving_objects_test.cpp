// Several virtual objects, and moving ones.
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "ground_stage.h"
#include "pipeline/display_codes.h"

namespace pleinair::moving_objects_test {
namespace {

using testing::HasSubstr;

const Material kRed{
    .name = "red", .diffuse_albedo = {0.6f, 0.1f, 0.1f}, .specular_reflectance = {}};
const Material kMirror{.name = "mirror",
                       .diffuse_albedo = glm::vec3(0.0f),
                       .specular_reflectance = glm::vec3(0.8f),
                       .roughness = 0.1f};

class MovingObjects : public testing::Test {
 protected:
  static void SetUpTestSuite() { stage_ = std::make_unique<GroundStage>(); }
  static void TearDownTestSuite() { stage_.reset(); }
  static std::unique_ptr<GroundStage> stage_;
};

std::unique_ptr<GroundStage> MovingObjects::stage_;

// A red box and a mirror beside it.
std::vector<VirtualObject> TwoBoxes() {
  return {BoxObject({-0.9f, -0.3f, 0.0f}, {-0.3f, 0.3f, 0.8f}, kRed),
          BoxObject({0.2f, -0.2f, 0.0f}, {0.7f, 0.3f, 0.6f}, kMirror)};
}

glm::dmat4 Turned() {
  return glm::rotate(
      glm::translate(glm::dmat4(1.0), glm::dvec3(0.3, 0.2, 0.1)), 0.4, glm::dvec3(0.0, 0.0, 1.0));
}

std::vector<FramePipelineOptions> EveryRoute() {
  std::vector<FramePipelineOptions> routes(4, GroundStage::QuickOptions());
  routes[1].object_light.route = ObjectLight::kVolume;
  routes[1].effects[Effect::kPenumbra] = EffectSwitch::kOff;
  routes[2].object_light.daylight = Daylight::kSamples;
  routes[2].object_light.direct_daylight.sampling.samples = 16;
  routes[3].object_light.route = ObjectLight::kVolumeByMap;
  routes[3].influence_at = InfluenceAt::kFaces;
  routes[3].view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
  return routes;
}

std::size_t ChangedPixels(const Composite& composite) {
  std::size_t changed = 0;
  for (const std::uint8_t change : composite.change.pixels) changed += change != 0 ? 1 : 0;
  return changed;
}

TEST_F(MovingObjects, AMovedObjectIsAsOneThatStandsThereByEveryRoute) {
  const std::vector<VirtualObject> objects = TwoBoxes();
  std::vector<VirtualObject> there = objects;
  there[0].mesh = TransformMesh(Turned(), there[0].mesh);
  for (const FramePipelineOptions& options : EveryRoute()) {
    const std::vector<FrameResult> moved =
        stage_->Run(objects, options, {{}, {Turned(), glm::dmat4(1.0)}, {}});
    const FrameResult expected = std::move(stage_->Run(there, options).front());
    EXPECT_EQ(moved[1].composite.radiance.pixels, expected.composite.radiance.pixels);
    EXPECT_EQ(moved[1].composite.change.pixels, expected.composite.change.pixels);
    EXPECT_NE(moved[0].composite.radiance.pixels, moved[1].composite.radiance.pixels);
    EXPECT_EQ(moved[0].composite.radiance.pixels, moved[2].composite.radiance.pixels);
  }
}

TEST_F(MovingObjects, WhatStandsStillIsNotRecomputed) {
  FramePipelineOptions options = GroundStage::QuickOptions();
  options.object_light.daylight = Daylight::kSamples;
  options.object_light.direct_daylight.sampling.samples = 16;
  const std::vector<glm::dmat4> poses{Turned(), glm::dmat4(1.0)};
  const std::vector<FrameResult> results = stage_->Run(TwoBoxes(), options, {{}, {}, poses, poses});
  EXPECT_GT(results[0].daylight->maps_drawn, 0u);
  EXPECT_EQ(results[1].daylight->maps_drawn, 0u);
  EXPECT_GT(results[2].daylight->maps_drawn, 0u);
  EXPECT_EQ(results[3].daylight->maps_drawn, 0u);
  EXPECT_EQ(results[2].composite.radiance.pixels, results[3].composite.radiance.pixels);
}

// The sun stands in the east: a box that goes 1 m to the east takes its shadow along, 100 px/m over
// a distance of 6 m.
TEST_F(MovingObjects, TheShadowGoesAlong) {
  const auto shadow_x = [](const Composite& composite) {
    double sum = 0.0;
    int count = 0;
    for (int y = 0; y < composite.change.height; ++y) {
      for (int x = 0; x < composite.change.width; ++x) {
        if (composite.change.At(x, y) != static_cast<std::uint8_t>(PixelChange::kScaled)) continue;
        // Ground that has lost most of its light, and not what the sky alone loses.
        if (composite.radiance.At(x, y).g > 25.0f) continue;
        sum += x;
        ++count;
      }
    }
    EXPECT_GT(count, 30);
    return sum / count;
  };
  const std::vector<VirtualObject> objects{
      BoxObject({-0.2f, -0.2f, 0.0f}, {0.2f, 0.2f, 1.0f}, kRed)};
  const glm::dmat4 to_the_east = glm::translate(glm::dmat4(1.0), glm::dvec3(1.0, 0.0, 0.0));
  const std::vector<FrameResult> results =
      stage_->Run(objects, GroundStage::QuickOptions(), {{}, {to_the_east}});
  EXPECT_NEAR(shadow_x(results[1].composite) - shadow_x(results[0].composite), 100.0 / 6.0, 2.0);
}

// What objects do to each other is what parts of one do: shade, hide, light and mirror.
TEST_F(MovingObjects, TwoObjectsAreAsOneOfBoth) {
  std::vector<VirtualObject> two = TwoBoxes();
  Mesh whole = two[0].mesh;
  const auto first = static_cast<std::uint32_t>(whole.positions_m.size());
  for (std::size_t v = 0; v < two[1].mesh.positions_m.size(); ++v) {
    whole.positions_m.push_back(two[1].mesh.positions_m[v]);
    whole.normals.push_back(two[1].mesh.normals[v]);
  }
  for (const glm::uvec3& triangle : two[1].mesh.triangles) {
    whole.triangles.push_back(triangle + first);
    whole.triangle_material.push_back(1);
    whole.triangle_group.push_back(0);
  }
  whole.materials.push_back(kMirror);
  for (const FramePipelineOptions& options : EveryRoute()) {
    const Composite of_two = std::move(stage_->Run(two, options).front().composite);
    const Composite of_one = std::move(stage_->Run({{whole}}, options).front().composite);
    // Light on the ground is computed around each object: where the places differ, by as much as
    // their rays are noisy.
    std::size_t apart = 0;
    for (std::size_t i = 0; i < of_one.radiance.pixels.size(); ++i) {
      const float difference = std::abs(of_two.radiance.pixels[i].r - of_one.radiance.pixels[i].r);
      apart += difference > 0.03f * of_one.radiance.pixels[i].r ? 1 : 0;
    }
    EXPECT_LE(apart, ChangedPixels(of_one) / 50);
  }
}

// A plate over a box, and nothing else that could take its sun; by penumbrae and by volumes.
TEST_F(MovingObjects, OneObjectShadesTheOther) {
  const VirtualObject box = BoxObject({-0.4f, -0.4f, 0.0f}, {0.4f, 0.4f, 0.4f}, kRed);
  const VirtualObject plate = BoxObject({0.6f, -1.5f, 1.2f}, {2.2f, 1.5f, 1.25f}, kRed);
  for (const bool penumbra : {true, false}) {
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.effects[Effect::kPenumbra] = penumbra ? EffectSwitch::kOn : EffectSwitch::kOff;
    const Composite alone = std::move(stage_->Run({box}, options).front().composite);
    const Composite shaded = std::move(stage_->Run({box, plate}, options).front().composite);
    // The middle of the box's top: 0.4 m over the origin.
    const glm::vec3 in_sun = alone.radiance.At(48, 29);
    const glm::vec3 in_shade = shaded.radiance.At(48, 29);
    const double of_sun = 0.6 * std::numbers::inv_pi * StillLight::kSun * std::sqrt(0.5);
    // Beside the sun the plate takes some of the sky, at most all of it.
    EXPECT_GT(in_sun.r - in_shade.r, 0.98 * of_sun) << "penumbra " << penumbra;
    EXPECT_LT(in_sun.r - in_shade.r, of_sun + 0.6 * std::numbers::inv_pi * StillLight::kSky);
    EXPECT_GT(in_shade.r, 0.0f);
  }
}

// Vertices enough that light follows them in steps, and light at them whatever the plan would say.
VirtualObject Ball(const glm::vec3& centre_m) { return BallObject(centre_m, 0.4f, 16, kRed); }

FramePipelineOptions InSteps() {
  FramePipelineOptions options = GroundStage::QuickOptions();
  options.light_in_steps = true;
  options.object_light.in_motion = {.vertices_per_frame = 128, .vertices_at_rest = 128};
  options.effects = EffectSettings::Everything();
  options.influence.in_motion.rays_per_receiver = options.influence.rays_per_receiver;
  return options;
}

constexpr double kFrameS = 0.04;

// Poses of some frames: to the east, and turned around the origin.
std::vector<std::vector<glm::dmat4>> Path(int frames,
                                          double turn_a_frame_rad = 0.0,
                                          double step_m = 0.04) {
  std::vector<std::vector<glm::dmat4>> poses{{glm::dmat4(1.0)}};
  for (int i = 1; i <= frames; ++i) {
    const glm::dmat4 there = glm::translate(glm::dmat4(1.0), glm::dvec3(step_m * i, 0.0, 0.0));
    poses.push_back({glm::rotate(there, turn_a_frame_rad * i, glm::dvec3(0.0, 0.0, 1.0))});
  }
  return poses;
}

// Over the pixels that an object covers or changes, in decibels of white.
double Psnr(const Composite& composite, const Composite& reference) {
  const DisplayCodes codes(ResponseCurve::Srgb(), 1.0 / 60.0);
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < reference.radiance.pixels.size(); ++i) {
    if (reference.change.pixels[i] == 0) continue;
    for (int channel = 0; channel < 3; ++channel) {
      const double off = codes.Code(channel, composite.radiance.pixels[i][channel]) -
                         codes.Code(channel, reference.radiance.pixels[i][channel]);
      sum += off * off;
      ++count;
    }
  }
  return 10.0 * std::log10(kWhiteCode * kWhiteCode * count / sum);
}

// 544 vertices are 9 parts, of which two are gathered in each frame at rest.
constexpr int kFramesToRest = 5;

TEST_F(MovingObjects, AtRestThePictureBecomesThatOfAStillObject) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  std::vector<std::vector<glm::dmat4>> poses = Path(4, 0.05);
  const std::size_t last_in_motion = poses.size() - 1;
  poses.insert(poses.end(), kFramesToRest, poses.back());
  const std::vector<FrameResult> results = stage_->Run(objects, InSteps(), poses, kFrameS);
  const Composite still =
      std::move(stage_->Run(objects, InSteps(), {poses.back()}).front().composite);
  EXPECT_NE(results[last_in_motion].composite.radiance.pixels, still.radiance.pixels);
  EXPECT_TRUE(results[last_in_motion].is_light_coarse);
  EXPECT_FALSE(results.back().is_light_coarse);
  EXPECT_EQ(results.back().composite.radiance.pixels, still.radiance.pixels);
}

TEST_F(MovingObjects, APictureInMotionIsAsGoodAsAStillOne) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  const std::vector<std::vector<glm::dmat4>> poses = Path(12);
  FramePipelineOptions converged = InSteps();
  converged.object_light.gather.rays_per_receiver = 2048;
  converged.influence.rays_per_receiver = 1024;
  const std::vector<FrameResult> moving = stage_->Run(objects, InSteps(), poses, kFrameS);
  // A mean over places: at one of them rays may be lucky.
  constexpr std::size_t kPlaces = 5;
  double lost_db = 0.0;
  for (std::size_t i = poses.size() - kPlaces; i < poses.size(); ++i) {
    const Composite reference =
        std::move(stage_->Run(objects, converged, {poses[i]}).front().composite);
    const Composite still =
        std::move(stage_->Run(objects, InSteps(), {poses[i]}).front().composite);
    lost_db += Psnr(still, reference) - Psnr(moving[i].composite, reference);
  }
  EXPECT_LT(lost_db / kPlaces, 1.0);
}

// All of it is gathered in each frame, with room for more.
TEST_F(MovingObjects, AnObjectOfFewVerticesIsAsAStillOneInEachFrame) {
  const std::vector<VirtualObject> objects{
      BoxObject({-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.8f}, kRed)};
  FramePipelineOptions options = InSteps();
  options.influence.in_motion.rays_per_receiver = 0;
  const std::vector<std::vector<glm::dmat4>> poses = Path(64, 0.05, 0.005);
  const std::vector<FrameResult> moving = stage_->Run(objects, options, poses, kFrameS);
  for (std::size_t i = 0; i < poses.size(); i += 16) {
    const Composite still = std::move(stage_->Run(objects, options, {poses[i]}).front().composite);
    EXPECT_EQ(moving[i].composite.radiance.pixels, still.radiance.pixels) << "frame " << i;
  }
}

// What is no motion: the same time again, a time before, a gap; and no motion is looked for unless
// asked for.
TEST_F(MovingObjects, AnObjectThatIsElsewhereAtOnceIsAsAStillOne) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  const std::vector<std::vector<glm::dmat4>> poses = Path(2, 0.05);
  const auto last_of = [&](const FramePipelineOptions& options, double apart_s) {
    FrameResult result = std::move(stage_->Run(objects, options, poses, apart_s).back());
    EXPECT_FALSE(result.is_light_coarse);
    return result.composite.radiance.pixels;
  };
  const auto still =
      stage_->Run(objects, InSteps(), {poses.back()}).front().composite.radiance.pixels;
  FramePipelineOptions at_once = InSteps();
  at_once.light_in_steps = false;
  EXPECT_EQ(last_of(InSteps(), 0.0), still);
  EXPECT_EQ(last_of(InSteps(), -kFrameS), still);
  EXPECT_EQ(last_of(InSteps(), 0.6), still);
  EXPECT_EQ(last_of(at_once, kFrameS), still);
  EXPECT_NE(stage_->Run(objects, InSteps(), poses, kFrameS).back().composite.radiance.pixels,
            still);
}

// In the middle of a motion, and while it is being refined.
TEST_F(MovingObjects, AFrameThatIsDrawnAgainIsAsAStillOne) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  const std::vector<std::vector<glm::dmat4>> poses = Path(3, 0.05);
  const auto still =
      stage_->Run(objects, InSteps(), {poses.back()}).front().composite.radiance.pixels;
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline({stage_->Scene(), stage_->Phantom(), std::nullopt, objects},
                         std::make_unique<StillLight>(),
                         compositor,
                         InSteps());
  Frame frame = stage_->MakeFrame();
  const auto next = [&](const std::vector<glm::dmat4>& of_frame) {
    frame.time += std::chrono::milliseconds(40);
    return pipeline.Process(frame, of_frame).value();
  };
  for (const int frames_at_rest : {0, 1, 2}) {
    FrameResult last;
    for (const std::vector<glm::dmat4>& of_frame : poses) last = next(of_frame);
    for (int i = 0; i < frames_at_rest; ++i) last = next(poses.back());
    EXPECT_TRUE(last.is_light_coarse) << frames_at_rest;
    const FrameResult again = pipeline.Redraw(frame, last, poses.back()).value();
    EXPECT_FALSE(again.is_light_coarse);
    EXPECT_EQ(again.composite.radiance.pixels, still) << frames_at_rest;
    EXPECT_EQ(next(poses.back()).composite.radiance.pixels, still) << frames_at_rest;
  }
}

FramePipelineOptions FirstInSteps() {
  FramePipelineOptions options = InSteps();
  options.first_in_steps = true;
  // Of 256 at other vertices; the influence is coarse by its rays alone.
  options.object_light.gather.rays_per_receiver = 256;
  options.object_light.in_motion.rays_at_first = 64;
  options.influence.in_motion.rays_per_receiver = options.influence.rays_per_receiver / 2;
  return options;
}

// Its light is that of fewer rays first: within 30 dB of white, and complete after a few frames.
TEST_F(MovingObjects, AFirstFrameInStepsIsFollowedByTheCompleteOne) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  const std::vector<std::vector<glm::dmat4>> poses(1 + kFramesToRest, {glm::dmat4(1.0)});
  const std::vector<FrameResult> results = stage_->Run(objects, FirstInSteps(), poses, kFrameS);
  FramePipelineOptions at_once = FirstInSteps();
  at_once.first_in_steps = false;
  const FrameResult complete = std::move(stage_->Run(objects, at_once, {poses.front()}).front());
  EXPECT_FALSE(complete.is_light_coarse);
  EXPECT_TRUE(results.front().is_light_coarse);
  EXPECT_NE(results.front().composite.radiance.pixels, complete.composite.radiance.pixels);
  EXPECT_GT(Psnr(results.front().composite, complete.composite), 30.0);
  EXPECT_FALSE(results.back().is_light_coarse);
  EXPECT_EQ(results.back().composite.radiance.pixels, complete.composite.radiance.pixels);
  // Nor is anything coarse without steps.
  at_once.first_in_steps = true;
  at_once.light_in_steps = false;
  EXPECT_FALSE(stage_->Run(objects, at_once, {poses.front()}).front().is_light_coarse);
}

// What was found with few rays is refined while the object moves, and leaves no trace at rest.
TEST_F(MovingObjects, OneThatMovesFromTheFirstFrameOnBecomesAsGood) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  std::vector<std::vector<glm::dmat4>> poses = Path(12);
  const std::size_t last_in_motion = poses.size() - 1;
  poses.insert(poses.end(), kFramesToRest, poses.back());
  FramePipelineOptions complete_first = FirstInSteps();
  complete_first.first_in_steps = false;
  FramePipelineOptions converged = complete_first;
  converged.object_light.gather.rays_per_receiver = 2048;
  converged.influence.rays_per_receiver = 1024;
  const Composite reference =
      std::move(stage_->Run(objects, converged, {poses.back()}).front().composite);
  const std::vector<FrameResult> coarse = stage_->Run(objects, FirstInSteps(), poses, kFrameS);
  const std::vector<FrameResult> fine = stage_->Run(objects, complete_first, poses, kFrameS);
  EXPECT_GT(Psnr(coarse[last_in_motion].composite, reference),
            Psnr(fine[last_in_motion].composite, reference) - 0.5);
  EXPECT_EQ(coarse.back().composite.radiance.pixels, fine.back().composite.radiance.pixels);
}

TEST_F(MovingObjects, StepsOfAMotionAreTheSameInEachRun) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  const std::vector<FrameResult> first = stage_->Run(objects, InSteps(), Path(3, 0.05), kFrameS);
  const std::vector<FrameResult> second = stage_->Run(objects, InSteps(), Path(3, 0.05), kFrameS);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].composite.radiance.pixels, second[i].composite.radiance.pixels);
  }
}

TEST_F(MovingObjects, OneThatStandsBesideAMovingOneKeepsItsLight) {
  const std::vector<VirtualObject> objects{Ball({-0.6f, 0.0f, 0.4f}), Ball({0.5f, 0.0f, 0.4f})};
  std::vector<std::vector<glm::dmat4>> poses = Path(6, 0.0, 0.005);
  for (std::vector<glm::dmat4>& of_frame : poses) {
    of_frame.insert(of_frame.begin(), glm::dmat4(1.0));
  }
  const std::size_t last_in_motion = poses.size() - 1;
  poses.insert(poses.end(), 2 * kFramesToRest, poses.back());
  FramePipelineOptions converged = InSteps();
  converged.object_light.gather.rays_per_receiver = 2048;
  converged.influence.rays_per_receiver = 1024;
  const Composite reference =
      std::move(stage_->Run(objects, converged, {poses.back()}).front().composite);
  const Composite still =
      std::move(stage_->Run(objects, InSteps(), {poses.back()}).front().composite);
  const std::vector<FrameResult> results = stage_->Run(objects, InSteps(), poses, kFrameS);
  EXPECT_GT(Psnr(results[last_in_motion].composite, reference), Psnr(still, reference) - 1.0);
  EXPECT_EQ(results.back().composite.radiance.pixels, still.radiance.pixels);
}

// A transform that bends the shape leaves nothing to keep.
TEST_F(MovingObjects, AnObjectThatIsStretchedIsAsOneThatWasMadeSo) {
  const std::vector<VirtualObject> objects{Ball({0.0f, 0.0f, 0.4f})};
  const std::vector<glm::dmat4> stretched{glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, 1.5))};
  std::vector<std::vector<glm::dmat4>> poses(1);
  poses.insert(poses.end(), 1 + kFramesToRest, stretched);
  const std::vector<FrameResult> results = stage_->Run(objects, InSteps(), poses, kFrameS);
  const Composite still = std::move(stage_->Run(objects, InSteps(), {stretched}).front().composite);
  EXPECT_EQ(results.back().composite.radiance.pixels, still.radiance.pixels);
}

TEST_F(MovingObjects, RefusesPosesThatMakeNoSenseAndGoesOn) {
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline({stage_->Scene(), stage_->Phantom(), std::nullopt, TwoBoxes()},
                         std::make_unique<StillLight>(),
                         compositor,
                         GroundStage::QuickOptions());
  const Frame frame = stage_->MakeFrame();
  const std::vector<glm::dmat4> one(1, glm::dmat4(1.0));
  const auto too_few = pipeline.Process(frame, one);
  ASSERT_FALSE(too_few);
  EXPECT_THAT(too_few.error().reason, HasSubstr("object poses: 1 for 2 objects"));
  const std::vector<glm::dmat4> flat{glm::dmat4(1.0),
                                     glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, 0.0))};
  const auto singular = pipeline.Process(frame, flat);
  ASSERT_FALSE(singular);
  EXPECT_THAT(singular.error().reason, HasSubstr("object 1: mesh transform"));
  const auto sound = pipeline.Process(frame);
  ASSERT_TRUE(sound);
  EXPECT_EQ(sound->composite.radiance.pixels,
            stage_->Run(TwoBoxes(), GroundStage::QuickOptions()).front().composite.radiance.pixels);
}

}  // namespace
}  // namespace pleinair::moving_objects_test

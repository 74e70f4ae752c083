// Daylight by samples, which a plan leaves out where windows are small and far.
#include <memory>
#include <optional>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "ground_stage.h"
#include "planned_frames.h"
#include "tests/relight/window_rooms.h"

namespace pleinair::planned_daylight_test {
namespace {

const WallHole kHole{{1.0f, 1.4f}, {2.0f, 2.4f}};

// A corridor of 40 m with a small window at its end, in dim walls.
class Corridor : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    site_ = std::make_unique<SiteModel>();
    site_->mesh = SheetRoom({kHole});
    for (glm::vec3& p : site_->mesh.positions_m) p.y *= 10.0f;
    site_->mesh.materials[0].diffuse_albedo = glm::vec3(0.3f);
    PrepareOptions options;
    options.gather.rays_per_receiver = 64;
    options.patches.patch_size_m = 2.0;
    options.patches.extend_ground = false;
    options.probes.rays_per_probe = 256;
    options.probe_box = {{0.3f, 0.3f, 0.2f}, {4.7f, 39.7f, 2.8f}};
    options.probe_counts = {3, 12, 3};
    KeepsNothing store;
    scene_ =
        std::make_unique<PreparedScene>(PrepareScene(*site_, options, store, [](auto, auto) {}));
  }
  static void TearDownTestSuite() {
    scene_.reset();
    site_.reset();
  }

  // A ball so far from the window, seen from beside it.
  static FrameResult Planned(float distance_m, const std::string& name) {
    FramePipelineOptions options = GroundStage::QuickOptions();
    options.object_light.route = ObjectLight::kVolume;
    options.object_light.daylight = Daylight::kSamples;
    options.object_light.direct_daylight.sampling.samples = 64;
    options.object_light.direct_daylight.windows = {SouthWindow(kHole)};
    Material plaster;
    plaster.diffuse_albedo = glm::vec3(0.6f);
    const HeadlessContext context;
    Compositor compositor;
    const auto make_pipeline = [&] {
      return FramePipeline({*scene_,
                            site_->mesh,
                            std::nullopt,
                            {BallObject({1.3f, distance_m, 1.2f}, 0.2f, 8, plaster)}},
                           std::make_unique<StillLight>(0.0, 50.0),
                           compositor,
                           options);
    };
    Frame frame;
    frame.camera.intrinsics = {64, 48, 80.0, 80.0, 31.5, 23.5, {}};
    // At eye height, looking west.
    const glm::dvec3 eye(4.0, distance_m, 1.4);
    const glm::dmat3 camera_from_world =
        glm::transpose(glm::dmat3({0.0, 1.0, 0.0}, {0.0, 0.0, -1.0}, {-1.0, 0.0, 0.0}));
    frame.camera.camera_from_world = glm::dmat4(camera_from_world);
    frame.camera.camera_from_world[3] = glm::dvec4(-(camera_from_world * eye), 1.0);
    frame.sun_direction_enu = glm::normalize(glm::dvec3(1.0, -1.0, 1.0));
    // Little of the window's light comes to the corridor's end.
    frame.radiance = RgbImage(64, 48, glm::vec3(distance_m < 10.0f ? 1.0f : 1e-5f));
    frame.unusable = Gray8Image(64, 48, 0);
    frame.clipped = Gray8Image(64, 48, 0);
    frame.exposure = 0.01;
    FramePipeline pipeline = make_pipeline();
    ExpectThatBoundsHold(pipeline, frame, name);
    // What another choice has left to be kept costs nothing: a pipeline of its own.
    FramePipeline fresh = make_pipeline();
    return ProcessWith(fresh, frame, EffectSettings());
  }

 private:
  static std::unique_ptr<SiteModel> site_;
  static std::unique_ptr<PreparedScene> scene_;
};

std::unique_ptr<SiteModel> Corridor::site_;
std::unique_ptr<PreparedScene> Corridor::scene_;

TEST_F(Corridor, ByTheWindowDaylightIsSampled) {
  const FrameResult near = Planned(1.5f, "near");
  EXPECT_EQ(near.plan.Of(Effect::kDaylight).fate, EffectFate::kRun);
}

TEST_F(Corridor, FarFromTheWindowTheVolumeWillDo) {
  const FrameResult far = Planned(38.0f, "far");
  const PlannedEffect& daylight = far.plan.Of(Effect::kDaylight);
  EXPECT_EQ(daylight.fate, EffectFate::kLeftOut);
  EXPECT_GT(daylight.bound_code_values, 0.0);
  EXPECT_TRUE(far.plan.runs.Has(Effect::kProbeShading));
}

}  // namespace
}  // namespace pleinair::planned_daylight_test

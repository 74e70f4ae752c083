// The effect plan held to its word on the recordings, prepared coarsely: the plan is about what
// effects do, not about how well the site is known.
#include "tests/pipeline/planned_frames.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "render/gl_context.h"
#include "session/sequence_session.h"
#include "session/session_choices.h"

namespace pleinair::planned_recorded_test {
namespace {

constexpr EffectSet kOfTheSun{
    Effect::kSunShading, Effect::kSunShadow, Effect::kObjectShadow, Effect::kPenumbra};

// Whether any of it is work: what is kept of the last frame costs nothing, and may go on for a sun
// of a thousandth of the sky.
bool WorksOnTheSun(const EffectPlan& plan) {
  return std::any_of(plan.effects.begin(), plan.effects.end(), [](const PlannedEffect& planned) {
    return planned.fate == EffectFate::kRun && kOfTheSun.Has(planned.effect);
  });
}

// Estimates each frame once: done again, it has the same light.
class LightOnce : public LightingSource {
 public:
  explicit LightOnce(std::unique_ptr<LightingSource> source) : source_(std::move(source)) {}

  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                   const SunState& sun) override {
    return source_->BasisFor(frame, sun);
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    if (!estimate_ || frame_ != observation.frame.index) {
      frame_ = observation.frame.index;
      estimate_ = source_->Estimate(observation);
    }
    return *estimate_;
  }

 private:
  std::unique_ptr<LightingSource> source_;
  int frame_ = -1;
  std::optional<tl::expected<LightingEstimate, LightingFailure>> estimate_;
};

struct RecordedFrame {
  int index;
  bool is_sunny;  // And the object in the sun.
};

void ExpectThePlanToHold(const std::string& name, const std::vector<RecordedFrame>& wanted) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences" / name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  LoadedSequence loaded;
  loaded.sequence = ReadSequence(folder);
  std::vector<FrameEntry> entries;
  for (const RecordedFrame& frame : wanted) {
    entries.push_back(loaded.sequence.frames.at(static_cast<std::size_t>(frame.index)));
  }
  loaded.sequence.frames = entries;
  loaded.site = LoadSequenceSite(loaded.sequence);
  PrepareOptions prepare = PrepareOptionsFor(loaded.site);
  prepare.gather.rays_per_receiver = 16;
  prepare.patches.patch_size_m = 2.0;
  prepare.probes.rays_per_probe = 16;
  prepare.probe_counts = {2, 2, 2};
  prepare.survey_receiver_block_px = 32;
  KeepsNothing store;
  loaded.scene = PrepareScene(loaded.site.model, prepare, store, [](auto, auto) {});
  FramePipelineOptions options = PipelineOptionsFor({}, loaded);
  options.view.receiver_block_px = 8;
  options.object_light.gather.rays_per_receiver = 16;
  options.influence.rays_per_receiver = 24;
  options.soft_sun.disc_samples = 8;
  options.mirror.rays_per_pixel = 2;
  options.mirror.rays_per_place = 1;
  options.filter.reset();
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline(
      {loaded.scene, loaded.site.model.mesh, loaded.sequence.site, loaded.site.objects},
      std::make_unique<LightOnce>(
          MakeSourceFor({}, loaded.sequence, loaded.scene.aerosol_optical_depth_500nm)),
      compositor,
      options);
  const auto frames = MakeRecordedFrameSource(loaded.sequence, FrameKind::kLinear);
  for (const RecordedFrame& recorded : wanted) {
    const Frame frame = frames->Next().value().value();
    const std::string what = name + ", frame " + std::to_string(recorded.index);
    const FrameResult planned = ExpectThatBoundsHold(pipeline, frame, what);
    EXPECT_EQ(WorksOnTheSun(planned.plan), recorded.is_sunny) << what;
    EXPECT_TRUE(planned.plan.runs.HasAll({Effect::kProbeShading, Effect::kSkyOcclusion})) << what;
  }
}

// In the last a thirtieth of the sky's light is the sun's.
TEST(PlannedRecordedFrames, CourtyardUnderSunAndCloud) {
  ExpectThePlanToHold("courtyard-clouds", {{2, true}, {11, false}, {18, true}});
}

// A glossy sphere that a building's shadow reaches.
TEST(PlannedRecordedFrames, ParkingLotInSunAndShade) {
  ExpectThePlanToHold("parking-shadow", {{1, true}, {8, false}});
}

TEST(PlannedRecordedFrames, RoomWithAndWithoutSunOnTheObject) {
  ExpectThePlanToHold("room-window", {{3, false}, {4, true}});
}

}  // namespace
}  // namespace pleinair::planned_recorded_test

// The entire frame at 640x480, with the plan and with everything on, under light that calls for
// more or less: the recorded courtyard and its statue, reduced to 4000 or 15000 faces. The camera
// stands still and a frame is a second after the last; files are read in advance and nothing is
// written. `moving` has the statue half a centimetre farther in each frame of 40 ms, lit in steps,
// `blurred` 8 cm, blurred by half of that; in `time_lapse` the sun alone moves, by a minute a
// frame. In the open field a ball of 4488 faces moves by a centimetre. Still ones and the ball also
// with a texture.
//
//   pleinair_plan_bench [Google Benchmark's options]
//
// Medians over frames, so that the sun's steps are not in them: of the entire frame, `median_ms`;
// of its processor time, all threads together, `cpu_ms`; of the estimate, `light_ms`; of the view
// and what effects need before drawing, `effects_ms`; of drawing, `draw_ms`; and `readback_ms`. In
// the open field `light_ms` is a mean, of light on the ball and of planning. Where objects move,
// `influence_ms` is what they do to real surfaces beside the sun's shadow.

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "bench/cut_mesh.h"
#include "bench/processor_time.h"
#include "bench/resized_frame.h"
#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "scene/mesh_io.h"
#include "scene/upper_median.h"
#include "session/file_blob_store.h"
#include "session/sequence_site.h"
#include "tests/pipeline/ground_stage.h"
#include "tests/render/textured_meshes.h"

namespace pleinair {
namespace {

enum class Under { kSun, kSunNoShadow, kCloud, kNight, kSunOutOfSight };
enum class Skin { kPlain, kTextured };
// Half a centimetre a frame; or eight centimetres, blurred by half of that; or the sun alone, a
// minute a frame.
enum class Motion { kNone, kSlow, kBlurred, kSun };

const std::filesystem::path kCourtyard =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/courtyard-clouds";

// Estimates as outdoors, then returns the bench's intensities.
class Staged : public LightingSource {
 public:
  explicit Staged(Under under) : under_(under) {}
  tl::expected<SkyBasis, LightingFailure> BasisFor(const Frame& frame,
                                                   const SunState& sun) override {
    return source_->BasisFor(frame, sun);
  }
  tl::expected<LightingEstimate, LightingFailure> Estimate(
      const LightingObservation& observation) override {
    auto estimate = source_->Estimate(observation);
    if (!estimate) return estimate;
    const bool is_sunny = under_ != Under::kCloud && under_ != Under::kNight;
    estimate->lighting.sun.irradiance_rgb =
        is_sunny ? glm::dvec3(1000.0, 950.0, 830.0) : glm::dvec3(0.0);
    for (SkyComponent& sky : estimate->lighting.sky) {
      sky.irradiance_rgb = under_ == Under::kNight ? glm::dvec3(0.0) : glm::dvec3(50.0, 60.0, 80.0);
    }
    return estimate;
  }

 private:
  Under under_;
  std::unique_ptr<LightingSource> source_ = MakeOutdoorLightingSource({});
};

// A million texels, a metre wide.
Mesh Painted(Mesh mesh) {
  const auto painted = test::Painted(test::RandomCodes(1024, 1024, 1));
  painted->dielectric_reflectance = mesh.materials.front().specular_reflectance;
  painted->roughness = mesh.materials.front().roughness;
  return test::Textured(std::move(mesh), painted, [](const glm::vec3& p) {
    return glm::vec2(p.x + 0.7f * p.y, p.z);
  });
}

// Time for the influence of objects in a frame.
double InfluenceMs(const FrameResult& result) {
  double ms = 0.0;
  for (const PlannedWork& work : result.works) {
    if (work.name == "influence on surfaces") ms += work.ms;
  }
  return ms;
}

struct Yard {
  Sequence sequence = ReadSequence(kCourtyard);
  SequenceSite site = LoadSequenceSite(sequence);
  PreparedScene scene;
  Frame frame;  // Of 640x480, in the sun.

  Yard() {
    FileBlobStore store;
    scene = PrepareScene(site.model, PrepareOptionsFor(site), store, [](auto, auto) {});
    const auto frames = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
    for (int i = 0; i < 8; ++i) frame = frames->Next()->value();
    Resize(640, 480, frame);
  }
};

struct FramesToRun {
  Under under = Under::kSun;
  std::size_t faces = 0;
  bool planned = true;  // False: every effect in every frame.
  Skin skin = Skin::kPlain;
  Motion motion = Motion::kNone;
};

void RunFrames(benchmark::State& state, const FramesToRun& run) {
  if (!std::filesystem::exists(kCourtyard)) {
    state.SkipWithError("the recorded courtyard is not there");
    return;
  }
  static const Yard yard;
  // Unchanged from its file: `run` would cut its large faces.
  const VirtualObjectEntry& statue = yard.sequence.virtual_objects.at(0);
  Mesh mesh = WithTriangles(
      TransformMesh(statue.world_from_object, LoadMesh(kCourtyard / statue.mesh).mesh), run.faces);
  state.counters["faces"] = static_cast<double>(mesh.triangles.size());
  if (run.skin == Skin::kTextured) mesh = Painted(std::move(mesh));
  const HeadlessContext context;
  Compositor compositor;
  FramePipelineOptions options;
  options.filter.reset();
  options.light_in_steps = true;
  if (!run.planned) options.effects = EffectSettings::Everything();
  if (run.under == Under::kSunNoShadow) {
    options.effects[Effect::kSunShadow] = EffectSwitch::kOff;
    options.effects[Effect::kObjectShadow] = EffectSwitch::kOff;
    options.effects[Effect::kPenumbra] = EffectSwitch::kOff;
  }
  FramePipeline pipeline(
      {yard.scene, yard.site.model.mesh, yard.sequence.site, {{std::move(mesh)}}},
      std::make_unique<Staged>(run.under),
      compositor,
      options);
  std::vector<glm::dmat4> poses;
  if (run.under == Under::kSunOutOfSight) {
    poses = {glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, -2000.0, 0.0))};
  }
  Frame frame = yard.frame;
  if (run.under == Under::kNight) frame.radiance = RgbImage(640, 480, glm::vec3(1e-6f));
  double at_m = 0.0;
  const bool moves = run.motion == Motion::kSlow || run.motion == Motion::kBlurred;
  if (run.motion == Motion::kBlurred) frame.exposure_s = 0.02;
  const auto next = [&] {
    if (moves) {
      frame.time += std::chrono::milliseconds(40);
      at_m += run.motion == Motion::kBlurred ? 0.08 : 0.005;
      poses = {glm::translate(glm::dmat4(1.0), glm::dvec3(at_m, 0.0, 0.0))};
    } else {
      frame.time += std::chrono::seconds(run.motion == Motion::kSun ? 60 : 1);
    }
    return pipeline.Process(frame, poses);
  };
  for (int i = 0; i < 2; ++i) {
    if (const auto first = next(); !first) {
      state.SkipWithError(first.error().reason.c_str());
      return;
    }
  }
  std::map<std::string, std::vector<double>> times_ms;
  for (auto _ : state) {
    const double cpu_before_ms = ProcessorMs();
    const auto start = std::chrono::steady_clock::now();
    const auto result = next();
    const std::chrono::duration<double, std::milli> whole =
        std::chrono::steady_clock::now() - start;
    benchmark::DoNotOptimize(result->composite.radiance.pixels.data());
    const StageTimes& stages = result->timing_ms;
    times_ms["median_ms"].push_back(whole.count());
    times_ms["cpu_ms"].push_back(ProcessorMs() - cpu_before_ms);
    times_ms["light_ms"].push_back(stages.estimate);
    times_ms["effects_ms"].push_back(stages.transport + stages.relight + stages.probes +
                                     result->planning_ms);
    times_ms["draw_ms"].push_back(stages.render);
    times_ms["readback_ms"].push_back(stages.readback);
    if (moves) times_ms["influence_ms"].push_back(InfluenceMs(*result));
    state.counters["draw_calls"] = result->composite.draw_calls;
  }
  for (const auto& [name, values] : times_ms) state.counters[name] = UpperMedian(values);
}

void RunOpenField(benchmark::State& state, bool planned, Skin skin = Skin::kPlain) {
  static const GroundStage stage;
  const HeadlessContext context;
  Compositor compositor;
  FramePipelineOptions options;
  options.filter.reset();
  if (!planned) options.effects = EffectSettings::Everything();
  const Material white{.name = "white", .diffuse_albedo = glm::vec3(0.6f)};
  VirtualObject ball = BallObject({0.0f, 0.0f, 0.4f}, 0.4f, 34, white);
  if (skin == Skin::kTextured) ball.mesh = Painted(std::move(ball.mesh));
  FramePipeline pipeline({stage.Scene(), stage.Phantom(), std::nullopt, {std::move(ball)}},
                         std::make_unique<StillLight>(),
                         compositor,
                         options);
  Frame frame = stage.MakeFrame();
  Resize(640, 480, frame);
  std::vector<double> whole_ms;
  std::vector<double> influence_ms;
  double light_ms = 0.0;  // Light on the ball, and planning.
  double at_m = 0.0;
  for (auto _ : state) {
    at_m = at_m < 0.5 ? at_m + 0.01 : 0.0;
    const std::vector<glm::dmat4> poses{
        glm::translate(glm::dmat4(1.0), glm::dvec3(at_m, 0.0, 0.0))};
    const auto start = std::chrono::steady_clock::now();
    const auto result = pipeline.Process(frame, poses);
    whole_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
    benchmark::DoNotOptimize(result->composite.radiance.pixels.data());
    state.counters["draw_calls"] = result->composite.draw_calls;
    influence_ms.push_back(InfluenceMs(*result));
    light_ms += result->planning_ms;
    for (const PlannedWork& work : result->works) {
      if (work.name.starts_with("light at ")) light_ms += work.ms;
    }
  }
  state.counters["light_ms"] = benchmark::Counter(light_ms, benchmark::Counter::kAvgIterations);
  state.counters["median_ms"] = UpperMedian(whole_ms);
  state.counters["influence_ms"] = UpperMedian(influence_ms);
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  using pleinair::Under;
  constexpr int kIterations = 96;  // Two steps of the sun's raster.
  for (const auto& [name, under] : {std::pair{"sun", Under::kSun},
                                    std::pair{"sun_without_shadows", Under::kSunNoShadow},
                                    std::pair{"cloud", Under::kCloud},
                                    std::pair{"night", Under::kNight},
                                    std::pair{"out_of_sight", Under::kSunOutOfSight}}) {
    for (const std::size_t faces : {4000, 15000}) {
      for (const bool planned : {true, false}) {
        benchmark::RegisterBenchmark(
            (std::string(name) + "/" + std::to_string(faces) + (planned ? "/plan" : "/all"))
                .c_str(),
            [under = under, planned, faces](benchmark::State& state) {
              pleinair::RunFrames(state, {.under = under, .faces = faces, .planned = planned});
            })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime()
            ->Iterations(kIterations);
      }
    }
  }
  for (const auto& [name, under] :
       {std::pair{"sun_textured", Under::kSun}, std::pair{"cloud_textured", Under::kCloud}}) {
    for (const std::size_t faces : {4000, 15000}) {
      benchmark::RegisterBenchmark(
          (std::string(name) + "/" + std::to_string(faces) + "/plan").c_str(),
          [under = under, faces](benchmark::State& state) {
            pleinair::RunFrames(
                state, {.under = under, .faces = faces, .skin = pleinair::Skin::kTextured});
          })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime()
          ->Iterations(kIterations);
    }
  }
  for (const bool planned : {true, false}) {
    benchmark::RegisterBenchmark(
        planned ? "open_field/plan" : "open_field/all",
        [planned](benchmark::State& state) { pleinair::RunOpenField(state, planned); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        ->Iterations(24);
  }
  benchmark::RegisterBenchmark("open_field_textured/plan",
                               [](benchmark::State& state) {
                                 pleinair::RunOpenField(state, true, pleinair::Skin::kTextured);
                               })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->Iterations(24);
  for (const auto& [name, motion] : {std::pair{"moving", pleinair::Motion::kSlow},
                                     std::pair{"blurred", pleinair::Motion::kBlurred},
                                     std::pair{"time_lapse", pleinair::Motion::kSun}}) {
    for (const std::size_t faces : {4000, 15000}) {
      benchmark::RegisterBenchmark(
          (std::string(name) + "/" + std::to_string(faces) + "/plan").c_str(),
          [motion = motion, faces](benchmark::State& state) {
            pleinair::RunFrames(state, {.faces = faces, .motion = motion});
          })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime()
          ->Iterations(24);
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

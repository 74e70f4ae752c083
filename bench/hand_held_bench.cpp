// A camera that is held in the hand: the recorded courtyard's frame 6 with its pose moved by a
// centimetre and a milliradian a frame, back and forth, under a sun that stands still. Files are
// read in advance and nothing is written. For each place of the scene's light, in the picture's own
// size and others, and for an object of a third of its size.
//
//   pleinair_hand_held_bench [Google Benchmark's options]
//
// Medians over frames, in ms: `median_ms` of the entire frame, `cpu_ms` its processor time (all
// threads together), `view_ms`, `light_ms` and `draw_ms` its parts. `first_ms` is the first frame.
//
// `first/...` are first frames alone, each of a new pipeline: complete ones, and ones in steps,
// which later frames refine. These frames take `rest_ms` together, the longest of them
// `rest_most_ms`. Parts of the first frame: `first_transport_ms` is the view, light on surfaces and
// gathering, and includes `first_works_ms`, what effects need; `first_draw_ms` is drawing.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "bench/processor_time.h"
#include "bench/recorded_courtyard.h"
#include "bench/resized_frame.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

using ReceiversAt = SurfaceViewOptions::ReceiversAt;

// About the middle of its foot.
VirtualObject Scaled(VirtualObject object, float scale) {
  const BoundingBox box = BoundingBoxOf(object.mesh);
  const glm::vec3 foot_m = {0.5f * (box.lower_m.x + box.upper_m.x),
                            0.5f * (box.lower_m.y + box.upper_m.y),
                            box.lower_m.z};
  for (glm::vec3& at : object.mesh.positions_m) at = foot_m + scale * (at - foot_m);
  return object;
}

void HandHeld(benchmark::State& state,
              int width_px,
              int height_px,
              ReceiversAt receivers_at,
              float object_scale = 1.0f) {
  if (!std::filesystem::exists(kRecordedCourtyard)) {
    state.SkipWithError("the recorded courtyard is not there");
    return;
  }
  static const RecordedCourtyard yard;
  Frame frame = yard.frame;
  if (width_px != frame.radiance.width) Resize(width_px, height_px, frame);
  const glm::dmat4 first_pose = frame.camera.camera_from_world;
  const HeadlessContext context;
  Compositor compositor;
  FramePipelineOptions options;
  options.view.receivers_at = receivers_at;
  if (receivers_at == ReceiversAt::kSurfaces) options.influence_at = InfluenceAt::kFaces;
  std::vector<VirtualObject> objects;
  for (const VirtualObject& object : yard.site.objects) {
    objects.push_back(Scaled(object, object_scale));
  }
  FramePipeline pipeline({yard.scene, yard.site.model.mesh, yard.sequence.site, objects},
                         MakeOutdoorLightingSource({}),
                         compositor,
                         options);
  std::map<std::string, std::vector<double>> times_ms;
  int i = 0;
  const auto next = [&] {
    frame.index = i;
    frame.camera.camera_from_world = HeldInTheHand(first_pose, i++);
    const double cpu_before_ms = ProcessorMs();
    const auto start = std::chrono::steady_clock::now();
    auto result = pipeline.Process(frame);
    const std::chrono::duration<double, std::milli> whole =
        std::chrono::steady_clock::now() - start;
    if (!result) {
      state.SkipWithError(result.error().reason.c_str());
      return whole.count();
    }
    const StageTimes& stages = result->timing_ms;
    times_ms["median_ms"].push_back(whole.count());
    times_ms["cpu_ms"].push_back(ProcessorMs() - cpu_before_ms);
    times_ms["view_ms"].push_back(stages.transport);
    times_ms["light_ms"].push_back(stages.estimate);
    times_ms["objects_ms"].push_back(stages.relight + stages.probes + result->planning_ms);
    times_ms["draw_ms"].push_back(stages.render + stages.readback);
    return whole.count();
  };
  state.counters["first_ms"] = next();
  times_ms.clear();
  for (auto _ : state) next();
  for (const auto& [name, values] : times_ms) state.counters[name] = UpperMedian(values);
}

// Medians over first frames.
void First(benchmark::State& state, int width_px, int height_px, ReceiversAt at, bool in_steps) {
  if (!std::filesystem::exists(kRecordedCourtyard)) {
    state.SkipWithError("the recorded courtyard is not there");
    return;
  }
  static const RecordedCourtyard yard;
  Frame frame = yard.frame;
  if (width_px != frame.radiance.width) Resize(width_px, height_px, frame);
  FramePipelineOptions options;
  options.view.receivers_at = at;
  if (at == ReceiversAt::kSurfaces) options.influence_at = InfluenceAt::kFaces;
  options.light_in_steps = in_steps;
  options.first_in_steps = in_steps;
  std::map<std::string, std::vector<double>> times_ms;
  for (auto _ : state) {
    state.PauseTiming();
    const HeadlessContext context;
    Compositor compositor;
    FramePipeline pipeline(
        {yard.scene, yard.site.model.mesh, yard.sequence.site, yard.site.objects},
        MakeOutdoorLightingSource({}),
        compositor,
        options);
    const auto next = [&](double& ms) {
      const auto start = std::chrono::steady_clock::now();
      auto result = pipeline.Process(frame);
      ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
               .count();
      return result;
    };
    double first_ms = 0.0;
    state.ResumeTiming();
    auto result = next(first_ms);
    state.PauseTiming();
    if (!result) return state.SkipWithError(result.error().reason.c_str());
    const StageTimes& stages = result->timing_ms;
    double works_ms = 0.0;
    for (const PlannedWork& work : result->works) works_ms += work.ms;
    times_ms["first_ms"].push_back(first_ms);
    times_ms["first_works_ms"].push_back(works_ms);
    times_ms["first_transport_ms"].push_back(stages.transport);
    times_ms["first_draw_ms"].push_back(stages.render + stages.readback);
    double rest_ms = 0.0;
    double most_ms = 0.0;
    while (result && result->is_light_coarse) {
      frame.time += std::chrono::milliseconds(40);
      double ms = 0.0;
      result = next(ms);
      rest_ms += ms;
      most_ms = std::max(most_ms, ms);
    }
    times_ms["rest_ms"].push_back(rest_ms);
    times_ms["rest_most_ms"].push_back(most_ms);
    state.ResumeTiming();
  }
  for (const auto& [name, values] : times_ms) state.counters[name] = UpperMedian(values);
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  using pleinair::ReceiversAt;
  for (const auto& [name, at] :
       {std::pair{"pixels", ReceiversAt::kPixels}, std::pair{"surfaces", ReceiversAt::kSurfaces}}) {
    for (const auto& [width, height] :
         {std::pair{480, 360}, std::pair{640, 480}, std::pair{1920, 1080}}) {
      benchmark::RegisterBenchmark(
          (std::string("hand_held/") + name + "/" + std::to_string(width)).c_str(),
          [=, at = at, width = width, height = height](benchmark::State& state) {
            pleinair::HandHeld(state, width, height, at);
          })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime()
          ->Iterations(at == ReceiversAt::kPixels ? 5 : 60);
    }
  }
  benchmark::RegisterBenchmark("hand_held/surfaces/1920/third_of_size",
                               [](benchmark::State& state) {
                                 constexpr float kThird = 1.0f / 3.0f;
                                 pleinair::HandHeld(
                                     state, 1920, 1080, ReceiversAt::kSurfaces, kThird);
                               })
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->Iterations(60);
  for (const auto& [name, at] :
       {std::pair{"pixels", ReceiversAt::kPixels}, std::pair{"surfaces", ReceiversAt::kSurfaces}}) {
    for (const bool in_steps : {false, true}) {
      benchmark::RegisterBenchmark(
          (std::string("first/") + name + "/480" + (in_steps ? "/in_steps" : "/complete")).c_str(),
          [=, at = at](benchmark::State& state) { pleinair::First(state, 480, 360, at, in_steps); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime()
          ->Iterations(7);
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

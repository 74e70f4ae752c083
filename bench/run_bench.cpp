// The complete `run` on one recorded frame, repeated with its time advanced by a second per frame,
// so that the sun's transport costs as much as it would live. Files are read in advance and nothing
// is written.
//
//   pleinair_run_bench [--sequence=DIR] [--frame=N] [Google Benchmark's options]

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "estimation/outdoor_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "session/file_blob_store.h"
#include "session/sequence_site.h"

namespace pleinair {
namespace {

struct BenchArguments {
  std::filesystem::path sequence = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
  int frame = 0;
};

struct Case {
  const char* name;
  ObjectLight object_light;
  bool objects_move = false;  // By a centimetre a frame.
  std::optional<double> budget_ms{};
  bool is_from_phone = false;  // 8 bit, without an exposure.
};

void RunRepeatedFrame(benchmark::State& state, const BenchArguments& arguments, const Case& one) {
  const Sequence sequence = ReadSequence(arguments.sequence);
  const SequenceSite site = LoadSequenceSite(sequence);
  FileBlobStore store;
  const PreparedScene scene =
      PrepareScene(site.model, PrepareOptionsFor(site), store, [](auto, auto) {});
  const HeadlessContext context;
  Compositor compositor;
  FramePipelineOptions options;
  options.object_light.route = one.object_light;
  options.effects.budget_ms = one.budget_ms;
  FramePipeline pipeline({scene, site.model.mesh, sequence.site, site.objects},
                         MakeOutdoorLightingSource({}),
                         compositor,
                         options);
  const auto frames =
      MakeRecordedFrameSource(sequence, one.is_from_phone ? FrameKind::kLdr : FrameKind::kLinear);
  Frame frame = frames->Next()->value();
  for (int i = 0; i < arguments.frame; ++i) frame = frames->Next()->value();
  if (one.is_from_phone) {
    frame.exposure.reset();
    frame.units = LightUnits::kRelativePerFrame;
  }
  if (!pipeline.Process(frame)) {  // The view's geometry, once.
    state.SkipWithError("the frame can't be done");
    return;
  }

  std::vector<glm::dmat4> poses(site.objects.size(), glm::dmat4(1.0));
  StageTimes sum;
  double dearest_transport_ms = 0.0;
  double left_out_rms = 0.0;
  for (auto _ : state) {
    frame.time += std::chrono::seconds(1);
    if (one.objects_move) {
      for (glm::dmat4& pose : poses) pose[3].x += 0.01;
    }
    const auto result = pipeline.Process(frame, poses);
    benchmark::DoNotOptimize(result->composite.radiance.pixels.data());
    const StageTimes& ms = result->timing_ms;
    sum.transport += ms.transport;
    sum.estimate += ms.estimate;
    sum.relight += ms.relight;
    sum.probes += ms.probes;
    sum.render += ms.render;
    sum.readback += ms.readback;
    left_out_rms += result->plan.left_out_rms_code_values;
    dearest_transport_ms = std::max(dearest_transport_ms, ms.transport);
  }
  const auto mean = [&](double total) {
    return benchmark::Counter(total, benchmark::Counter::kAvgIterations);
  };
  state.counters["transport_ms"] = mean(sum.transport);
  state.counters["transport_max_ms"] = dearest_transport_ms;
  state.counters["estimate_ms"] = mean(sum.estimate);
  state.counters["relight_ms"] = mean(sum.relight);
  state.counters["probes_ms"] = mean(sum.probes);
  state.counters["render_ms"] = mean(sum.render);
  state.counters["readback_ms"] = mean(sum.readback);
  state.counters["left_out_rms"] = mean(left_out_rms);
  state.counters["frames_per_second"] =
      benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  pleinair::BenchArguments arguments;
  std::vector<char*> rest;
  for (int i = 0; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with("--sequence=")) {
      arguments.sequence = argument.substr(11);
    } else if (argument.starts_with("--frame=")) {
      arguments.frame = std::stoi(argument.substr(8));
    } else {
      rest.push_back(argv[i]);
    }
  }
  int rest_count = static_cast<int>(rest.size());
  using pleinair::ObjectLight;
  const pleinair::Case cases[] = {
      {"run/gather", ObjectLight::kGather},
      {.name = "run/gather/phone", .object_light = ObjectLight::kGather, .is_from_phone = true},
      {"run/volume", ObjectLight::kVolume},
      {"run/volume_by_map", ObjectLight::kVolumeByMap},
      {"run_moving/gather", ObjectLight::kGather, true},
      {"run_moving/volume", ObjectLight::kVolume, true},
      {"run_moving/gather/budget:33", ObjectLight::kGather, true, 33.0},
      {"run_moving/volume/budget:33", ObjectLight::kVolume, true, 33.0}};
  for (const auto& one : cases) {
    benchmark::RegisterBenchmark(one.name,
                                 [arguments, one](benchmark::State& state) {
                                   pleinair::RunRepeatedFrame(state, arguments, one);
                                 })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime()
        // Four steps of the sun's raster; moved objects are the same in each frame.
        ->Iterations(one.objects_move ? 24 : 192);
  }
  benchmark::Initialize(&rest_count, rest.data());
  if (benchmark::ReportUnrecognizedArguments(rest_count, rest.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

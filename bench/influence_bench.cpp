// Times an object's influence on the real scene: set-up for a camera, folding for a sun, and a
// frame.
//
//   pleinair_influence_bench [--sequence=DIR] [Google Benchmark's options]

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "datasets/frame_source.h"
#include "datasets/sequence.h"
#include "objects/object_influence.h"
#include "objects/object_interreflection.h"
#include "pipeline/frame_pipeline.h"
#include "session/file_blob_store.h"
#include "session/sequence_site.h"

namespace pleinair {
namespace {

// The site of a sequence with its object, seen by the camera of its first frame.
struct Setting {
  explicit Setting(const std::filesystem::path& folder)
      : sequence(ReadSequence(folder)), site(LoadSequenceSite(sequence)) {
    FileBlobStore store;
    scene = PrepareScene(site.model, PrepareOptionsFor(site), store, [](auto, auto) {});
    const auto frames = MakeRecordedFrameSource(sequence, FrameKind::kLinear);
    const Frame frame = frames->Next()->value();
    const SunState sun = SunOfFrame(sequence.site, frame);
    builder = std::make_unique<SurfaceViewBuilder>(scene, SurfaceViewOptions{});
    view = builder->Update(
        frame.camera, sun.direction_enu, sun.angular_radius_rad, std::array{shape}, {});
    interreflection = std::make_unique<ObjectInterreflection>(site.objects);
    object_glow.assign(interreflection->Objects().FaceCount(), glm::vec3(0.2f));
    lighting.sky.resize(1);
    lighting.sky[0].irradiance_rgb = glm::dvec3(100.0);
    lighting.sun.irradiance_rgb = glm::dvec3(800.0);
  }

  void Fold(ObjectInfluence& influence) const {
    influence.Fold(0, {nullptr, builder->SunFaces().radiosity, object_glow}, view);
    influence.Fold(1, {shape.get(), builder->SkyFaces(0).radiosity, object_glow}, view);
  }

  Sequence sequence;
  SequenceSite site;
  PreparedScene scene;
  std::shared_ptr<const SkyShape> shape = MakeUniformSkyShape();
  std::unique_ptr<SurfaceViewBuilder> builder;
  SurfaceView view;
  std::unique_ptr<ObjectInterreflection> interreflection;
  std::vector<glm::vec3> object_glow;
  Lighting lighting;
};

void Gather(benchmark::State& state, const Setting& setting) {
  std::size_t receivers = 0;
  for (auto _ : state) {
    const ObjectInfluence influence(
        setting.scene.patches, setting.interreflection->Objects(), setting.view);
    receivers = influence.ReceiverCount();
  }
  state.counters["receivers"] = static_cast<double>(receivers);
}

void Fold(benchmark::State& state, const Setting& setting) {
  ObjectInfluence influence(
      setting.scene.patches, setting.interreflection->Objects(), setting.view);
  for (auto _ : state) setting.Fold(influence);
}

void Evaluate(benchmark::State& state, const Setting& setting) {
  ObjectInfluence influence(
      setting.scene.patches, setting.interreflection->Objects(), setting.view);
  setting.Fold(influence);
  IrradianceChange change;
  for (auto _ : state) {
    influence.Evaluate(setting.lighting, {}, change);
    benchmark::DoNotOptimize(change.irradiance_rgb.pixels.data());
  }
  state.counters["pixels"] = static_cast<double>(change.irradiance_rgb.pixels.size());
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  std::filesystem::path sequence = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";
  std::vector<char*> rest;
  for (int i = 0; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.starts_with("--sequence=")) {
      sequence = argument.substr(11);
    } else {
      rest.push_back(argv[i]);
    }
  }
  int rest_count = static_cast<int>(rest.size());
  benchmark::Initialize(&rest_count, rest.data());
  if (benchmark::ReportUnrecognizedArguments(rest_count, rest.data())) return 2;
  const pleinair::Setting setting(sequence);
  for (const auto& [name, run] : {std::pair{"influence/gather", &pleinair::Gather},
                                  std::pair{"influence/fold", &pleinair::Fold},
                                  std::pair{"influence/evaluate", &pleinair::Evaluate}}) {
    benchmark::RegisterBenchmark(
        name, [&setting, run = run](benchmark::State& state) { run(state, setting); })
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime()
        ->UseRealTime();
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

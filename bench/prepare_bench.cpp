// Times `prepare`, and a camera's view when it is new and when the sun has moved. Also measures
// what a coarser or finer preparation changes in the response on which the estimate depends.
//
//   pleinair_prepare_bench [--sequence=DIR] [Google Benchmark's options]

#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include "datasets/sequence.h"
#include "pipeline/sun_state.h"
#include "relight/prepared_scene.h"
#include "relight/surface_view_builder.h"
#include "session/sequence_site.h"
#include "sunmodel/sky_shapes.h"

namespace pleinair {
namespace {

std::filesystem::path g_sequence = PLEINAIR_SOURCE_DIR "/datasets/samples/courtyard";

struct Recorded {
  Sequence sequence = ReadSequence(g_sequence);
  SequenceSite site = LoadSequenceSite(sequence);
  Camera camera = sequence.CameraOfFrame(0);
  SunState sun = SunOverSite(sequence.site.value_or(Site{}), sequence.frames[0].time);

  PreparedScene Prepare(const PrepareOptions& options) const {
    KeepsNothing store;
    return PrepareScene(site.model, options, store, {});
  }
};

const Recorded& TheRecording() {
  static const Recorded recorded;
  return recorded;
}

const PreparedScene& ThePreparedScene() {
  static const PreparedScene scene = TheRecording().Prepare(PrepareOptionsFor(TheRecording().site));
  return scene;
}

void Prepare(benchmark::State& state) {
  const Recorded& recorded = TheRecording();
  const PrepareOptions options = PrepareOptionsFor(recorded.site);
  std::size_t patches = 0;
  for (auto _ : state) patches = recorded.Prepare(options).patches.PatchCount();
  state.counters["patches"] = static_cast<double>(patches);
}

// A shape that stays, and one that turns with the sun.
std::vector<std::shared_ptr<const SkyShape>> Shapes(const glm::dvec3& sun_direction_enu) {
  static const auto kUniform = MakeUniformSkyShape();
  return {kUniform, MakeClearSkyShape(sun_direction_enu)};
}

void NewCamera(benchmark::State& state) {
  const Recorded& recorded = TheRecording();
  SurfaceViewBuilder builder(ThePreparedScene(),
                             {.receiver_block_px = static_cast<int>(state.range(0))});
  const auto shapes = Shapes(recorded.sun.direction_enu);
  Camera camera = recorded.camera;
  for (auto _ : state) {
    camera.camera_from_world[3].x += 1e-3;
    builder.Update(camera, recorded.sun.direction_enu, recorded.sun.angular_radius_rad, shapes, {});
  }
}

void MovedSun(benchmark::State& state) {
  const Recorded& recorded = TheRecording();
  SurfaceViewBuilder builder(ThePreparedScene(), {});
  glm::dvec3 sun = recorded.sun.direction_enu;
  builder.Update(recorded.camera, sun, recorded.sun.angular_radius_rad, Shapes(sun), {});
  for (auto _ : state) {
    sun = glm::normalize(sun + glm::dvec3(1e-3, 0.0, 0.0));
    builder.Update(recorded.camera, sun, recorded.sun.angular_radius_rad, Shapes(sun), {});
  }
}

// The map's part of a moved sun, for the probes and whatever mirrors the map.
void MovedSunWithSurveyMap(benchmark::State& state) {
  const Recorded& recorded = TheRecording();
  SurfaceViewBuilder builder(ThePreparedScene(), {});
  glm::dvec3 sun = recorded.sun.direction_enu;
  builder.Update(recorded.camera, sun, recorded.sun.angular_radius_rad, Shapes(sun), {});
  builder.SurveyUnderCurrentSun();
  for (auto _ : state) {
    sun = glm::normalize(sun + glm::dvec3(1e-3, 0.0, 0.0));
    builder.Update(recorded.camera, sun, recorded.sun.angular_radius_rad, Shapes(sun), {});
    benchmark::DoNotOptimize(builder.SurveyUnderCurrentSun());
  }
}

// Arguments: rays a receiver, receivers' block side, patch size in cm. Reports the root mean square
// difference of the sky's response, relative, from the finest of them.
void PrepareAt(benchmark::State& state) {
  const Recorded& recorded = TheRecording();
  const auto response = [&](int rays, int block_px, double patch_size_m) {
    PrepareOptions options = PrepareOptionsFor(recorded.site);
    options.gather.rays_per_receiver = rays;
    options.survey_receiver_block_px = block_px;
    options.patches.patch_size_m = patch_size_m;
    const PreparedScene scene = recorded.Prepare(options);
    SurfaceViewBuilder builder(scene, {.receiver_block_px = block_px});
    return builder
        .Update(recorded.camera,
                recorded.sun.direction_enu,
                recorded.sun.angular_radius_rad,
                Shapes(recorded.sun.direction_enu),
                {})
        .sky_response[0];
  };
  static const RgbImage finest = response(1024, 2, 0.25);
  RgbImage now;
  for (auto _ : state) {
    now = response(static_cast<int>(state.range(0)),
                   static_cast<int>(state.range(1)),
                   0.01 * static_cast<double>(state.range(2)));
  }
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < now.pixels.size(); ++i) {
    if (!(finest.pixels[i].y > 0.0f)) continue;
    const double off = now.pixels[i].y / finest.pixels[i].y - 1.0;
    squares += off * off;
    count += 1.0;
  }
  state.counters["rms_of_response"] = std::sqrt(squares / count);
}

// CPU time of all threads beside wall time: the first is sound on a busy machine too.
void Configure(benchmark::internal::Benchmark* bench) {
  bench->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
}

BENCHMARK(Prepare)->Apply(Configure)->Iterations(1);
BENCHMARK(NewCamera)->Apply(Configure)->Arg(2)->Arg(4)->Arg(8);
BENCHMARK(MovedSun)->Apply(Configure);
BENCHMARK(MovedSunWithSurveyMap)->Apply(Configure);
BENCHMARK(PrepareAt)
    ->Apply(Configure)
    ->Iterations(1)
    ->Args({64, 8, 100})
    ->Args({128, 4, 50})
    ->Args({256, 8, 50})
    ->Args({256, 4, 50})
    ->Args({256, 4, 25})
    ->Args({1024, 4, 50});

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  constexpr char kSequence[] = "--sequence=";
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], kSequence, sizeof(kSequence) - 1) == 0) {
      pleinair::g_sequence = argv[i] + sizeof(kSequence) - 1;
    } else {
      argv[kept++] = argv[i];
    }
  }
  benchmark::Initialize(&kept, argv);
  if (benchmark::ReportUnrecognizedArguments(kept, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

// The entire frame indoors while the camera moves: the recorded room at 512x496, lit by its
// fish-eye pictures through the window, objects of 4000 and more faces. The camera walks around the
// object; files are read before and nothing is written.
//
//   pleinair_room_frame_bench [Google Benchmark's options]
//
// `camera` holds the sky, `camera_and_sky` has a new fish-eye picture every frame, `still` neither.

#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/gtc/matrix_transform.hpp>

#include "bench/recorded_place.h"
#include "bench/resized_frame.h"
#include "datasets/fisheye_setup.h"
#include "datasets/sequence.h"
#include "estimation/fisheye_lighting_source.h"
#include "pipeline/frame_pipeline.h"
#include "render/gl_context.h"
#include "session/sequence_site.h"

namespace pleinair {
namespace {

const std::filesystem::path kFolder =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/room-window";

enum class What { kStill, kCamera, kCameraAndSky };

struct Room : RecordedPlace {
  RgbImage first_sky;
  RgbImage second_sky;

  Room() : RecordedPlace(kFolder, 4) {
    first_sky = *frame.fisheye_radiance;
    second_sky = *later_frames->Next()->value().fisheye_radiance;
    Resize(512, 496, frame);
  }

  // Turned around the object, back and forth over 40 deg, by about a third of a degree a frame.
  Camera CameraAt(int step) const {
    const glm::dvec3 middle_m(0.5f *
                              (scene.options.probe_box.lower_m + scene.options.probe_box.upper_m));
    const double angle = 0.35 * std::sin(0.0167 * step);
    const glm::dmat4 turn = glm::translate(glm::dmat4(1.0), middle_m) *
                            glm::rotate(glm::dmat4(1.0), angle, glm::dvec3(0.0, 0.0, 1.0)) *
                            glm::translate(glm::dmat4(1.0), -middle_m);
    Camera camera = frame.camera;
    camera.camera_from_world = camera.camera_from_world * turn;
    return camera;
  }

  // One picture turning into the other.
  RgbImage SkyAt(int step) const {
    const float share = 0.5f - 0.5f * std::cos(0.02f * static_cast<float>(step));
    RgbImage sky = first_sky;
    for (std::size_t i = 0; i < sky.pixels.size(); ++i) {
      sky.pixels[i] += share * (second_sky.pixels[i] - first_sky.pixels[i]);
    }
    return sky;
  }
};

void RunRoom(benchmark::State& state, What what, const FramePipelineOptions& options) {
  if (!std::filesystem::exists(kFolder)) {
    state.SkipWithError("the recorded room is not there");
    return;
  }
  static const Room room;
  const HeadlessContext context;
  Compositor compositor;
  FramePipeline pipeline(
      {room.scene, room.site.model.mesh, room.sequence.site, room.site.objects},
      MakeFisheyeLightingSource(MakeFisheyeSetup(*room.sequence.fisheye, kFolder).camera, {}),
      compositor,
      options);
  Frame frame = room.frame;
  frame.camera = room.CameraAt(0);
  if (const auto first = pipeline.Process(frame); !first) {
    state.SkipWithError(first.error().reason.c_str());
    return;
  }
  StageTimes sum;
  double fastest_ms = std::numeric_limits<double>::infinity();
  double maps_drawn = 0.0;
  int step = 0;
  for (auto _ : state) {
    state.PauseTiming();
    ++step;
    if (what != What::kStill) frame.camera = room.CameraAt(step);
    if (what == What::kCameraAndSky) frame.fisheye_radiance = room.SkyAt(step);
    state.ResumeTiming();
    const auto start = std::chrono::steady_clock::now();
    const auto result = pipeline.Process(frame);
    fastest_ms =
        std::min(fastest_ms,
                 std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                     .count());
    benchmark::DoNotOptimize(result->composite.radiance.pixels.data());
    const StageTimes& ms = result->timing_ms;
    if (result->daylight) maps_drawn += static_cast<double>(result->daylight->maps_drawn);
    sum.transport += ms.transport;
    sum.estimate += ms.estimate;
    sum.probes += ms.probes;
    sum.render += ms.render;
    sum.readback += ms.readback;
  }
  const auto mean = [&](double total) {
    return benchmark::Counter(total, benchmark::Counter::kAvgIterations);
  };
  state.counters["transport_ms"] = mean(sum.transport);
  state.counters["estimate_ms"] = mean(sum.estimate);
  state.counters["light_ms"] = mean(sum.probes);
  state.counters["render_ms"] = mean(sum.render);
  state.counters["readback_ms"] = mean(sum.readback);
  std::size_t faces = 0;
  for (const VirtualObject& object : room.site.objects) faces += object.mesh.triangles.size();
  state.counters["maps_drawn"] = mean(maps_drawn);
  state.counters["fastest_ms"] = fastest_ms;
  state.counters["faces"] = static_cast<double>(faces);
  state.counters["frames_per_second"] =
      benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);
}

FramePipelineOptions Route(ObjectLight object_light, Daylight daylight) {
  FramePipelineOptions options;
  options.object_light.route = object_light;
  options.object_light.daylight = daylight;
  options.object_light.direct_daylight.sampling.samples = 64;
  options.object_light.direct_daylight.shadows.map_size_px = 32;
  options.view.receivers_at = SurfaceViewOptions::ReceiversAt::kSurfaces;
  options.view.sun_block_px = 4;
  options.influence_at = InfluenceAt::kFaces;
  return options;
}

}  // namespace
}  // namespace pleinair

int main(int argc, char** argv) {
  using namespace pleinair;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const std::pair<const char*, FramePipelineOptions> routes[] = {
      {"gather", Route(ObjectLight::kGather, Daylight::kGather)},
      {"samples", Route(ObjectLight::kGather, Daylight::kSamples)},
      {"volume", Route(ObjectLight::kVolume, Daylight::kSamples)}};
  const std::pair<const char*, What> whats[] = {
      {"still", What::kStill}, {"camera", What::kCamera}, {"camera_and_sky", What::kCameraAndSky}};
  for (const auto& [route, options] : routes) {
    for (const auto& [name, what] : whats) {
      benchmark::RegisterBenchmark((std::string("room/") + route + "/" + name).c_str(),
                                   [options = options, what = what](benchmark::State& state) {
                                     RunRoom(state, what, options);
                                   })
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime()
          ->UseRealTime()
          ->Iterations(20);
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

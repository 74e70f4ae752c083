// Times direct daylight by samples in the recorded room with its object and camera: drawing samples
// of a new sky, shadow maps, light at the object's vertices, and new shadows at points of the
// floor. The benchmarks' argument is the number of samples.
//
//   pleinair_daylight_bench [Google Benchmark's options]

#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "objects/daylight_shadows.h"
#include "relight/daylight/window_sampling.h"
#include "relight/daylight/windows.h"
#include "scene/mesh_io.h"
#include "scene/ray_caster.h"

namespace pleinair {
namespace {

const std::filesystem::path kFolder =
    std::filesystem::path(PLEINAIR_SHARED_DIR) / "sequences/room-window";

// The object at its place in the room; the rest of sequence.json's transform does not matter here.
Mesh ObjectInTheRoom() {
  return TransformMesh(glm::translate(glm::dmat4(1.0), glm::dvec3(1.95, 1.75, 0.0)),
                       LoadMesh(kFolder / "object.obj").mesh);
}

struct Room {
  Mesh mesh = LoadMesh(kFolder / "scene.obj").mesh;
  Mesh object = ObjectInTheRoom();
  RayCaster real{mesh};
  RayCaster objects{object};
  BoundingSphere sphere = BoundingSphereOf(object.positions_m);
  std::vector<Window> windows = FindWindows(mesh, std::vector<glm::dvec3>{sphere.centre_m}).windows;
  std::vector<glm::vec3> sky;
  std::vector<Receiver> vertices;
  std::vector<Receiver> floor;

  Room() {
    for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
      sky.push_back(glm::vec3(2.0f - glm::vec3(SkyTable::DirectionOfCell(cell)).z));
    }
    for (std::size_t v = 0; v < object.positions_m.size(); ++v) {
      vertices.push_back({object.positions_m[v], object.normals[v]});
    }
    // As many as in every second pixel of a 512x496 picture where an object fills much of it.
    for (int i = 0; i < 128; ++i) {
      for (int k = 0; k < 128; ++k) {
        floor.push_back({{0.9f + 2.1f * static_cast<float>(i) / 128.0f,
                          0.7f + 2.1f * static_cast<float>(k) / 128.0f,
                          0.0f},
                         {0.0f, 0.0f, 1.0f}});
      }
    }
  }
  std::vector<DaylightSample> Samples(std::int64_t count, std::uint64_t seed = 1) const {
    return DaylightSampler(windows,
                           sphere,
                           {.samples = static_cast<int>(count),
                            .restriction = DaylightRestriction::kWindows,
                            .seed = seed})
        .Draw(sky)
        .samples;
  }
};

// Null where the recording is missing.
const Room* TheRoom(benchmark::State& state) {
  if (!std::filesystem::exists(kFolder)) {
    state.SkipWithError("the recorded room is not there");
    return nullptr;
  }
  static const Room room;
  return &room;
}

void BM_FindWindows(benchmark::State& state) {
  const Room* room = TheRoom(state);
  if (room == nullptr) return;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        FindWindows(room->mesh, std::vector<glm::dvec3>{room->sphere.centre_m}));
  }
}
BENCHMARK(BM_FindWindows)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_DrawSamples(benchmark::State& state) {
  const Room* room = TheRoom(state);
  if (room == nullptr) return;
  const DaylightSampler sampler(
      room->windows, room->sphere, {.samples = static_cast<int>(state.range(0))});
  for (auto _ : state) benchmark::DoNotOptimize(sampler.Draw(room->sky));
}
BENCHMARK(BM_DrawSamples)->Arg(64)->Unit(benchmark::kMillisecond);

void BM_ShadowMaps(benchmark::State& state) {
  const Room* room = TheRoom(state);
  if (room == nullptr) return;
  const std::array samples{room->Samples(state.range(0), 1), room->Samples(state.range(0), 2)};
  DaylightShadows shadows(room->real, room->objects, room->sphere);
  std::size_t turn = 0;
  for (auto _ : state) shadows.SetSamples(samples[turn++ % 2]);
  state.counters["maps"] = static_cast<double>(shadows.MapsDrawn());
}
BENCHMARK(BM_ShadowMaps)->Arg(64)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_VertexLight(benchmark::State& state) {
  const Room* room = TheRoom(state);
  if (room == nullptr) return;
  DaylightShadows shadows(room->real, room->objects, room->sphere);
  shadows.SetSamples(room->Samples(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(shadows.OnObjects(room->vertices));
  state.counters["vertices"] = static_cast<double>(room->vertices.size());
}
BENCHMARK(BM_VertexLight)->Arg(16)->Arg(64)->Unit(benchmark::kMillisecond)->UseRealTime();

// Shadows by maps of 64^2, and by one ray per sample.
void BM_NewShadows(benchmark::State& state) {
  const Room* room = TheRoom(state);
  if (room == nullptr) return;
  const auto map_size_px = static_cast<int>(state.range(1));
  DaylightShadows shadows(room->real, room->objects, room->sphere, {.map_size_px = map_size_px});
  shadows.SetSamples(room->Samples(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(shadows.HiddenFrom(room->floor));
  state.counters["receivers"] = static_cast<double>(room->floor.size());
}
BENCHMARK(BM_NewShadows)
    ->Args({64, 64})
    ->Args({64, 0})
    ->Args({16, 64})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();

// What the radiosity of 64 sky regions costs, and how far it is from a converged one: 2400 patches
// of a room with a window, as bench/relight_bench.cpp has it.
//
//   pleinair_radiosity_bench [Google Benchmark's options]
//
// The reference (same patches, other rays: 8192 of form factors a face, 8 x 2^17 to the sky by
// SkyVisibility) takes a minute or two; its own noise is in the errors.

#include <cmath>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include "relight/region_radiosity.h"
#include "relight/sky_visibility.h"
#include "tests/relight/window_room.h"

namespace pleinair {
namespace {

PatchTransport TransportOf(const PatchScene& scene, int rays, std::uint64_t seed) {
  GatherOptions options;
  options.rays_per_receiver = rays;
  options.seed = seed;
  options.from_exposed_parts = true;
  return {scene, options};
}

struct Room {
  static constexpr std::size_t kRegions = 64;

  PatchScene scene = CutRoom(RoomWithWindow({0.7f, 0.6f, 0.5f}), 0.8);
  std::vector<glm::vec3> converged;

  Room() {
    constexpr int kSets = 8;
    const PatchTransport transport = TransportOf(scene, 8192, 7);
    std::vector<glm::vec3> direct(scene.FaceCount() * kRegions, glm::vec3(0.0f));
    for (int set = 0; set < kSets; ++set) {
      const auto directions = std::make_shared<SkyDirections>(
          SkyRegions(), (1 << 17) / static_cast<int>(kRegions), 100 + set);
      const std::vector<float> of_set =
          SkyVisibility::OfFaces(scene, transport.Points(), directions).FromRegions();
      for (std::size_t i = 0; i < direct.size(); ++i) direct[i] += of_set[i] / float{kSets};
    }
    SolveOptions options;
    options.tolerance = 1e-5;
    converged = transport.SolveMany(scene, direct, kRegions, options).radiosity;
  }

  bool IsInside(std::size_t face) const {
    const glm::uvec3& v = scene.mesh.triangles[face / 2];
    const std::vector<glm::vec3>& at = scene.mesh.positions_m;
    const glm::vec3 middle = (at[v.x] + at[v.y] + at[v.z]) / 3.0f + 0.01f * scene.FaceNormal(face);
    return glm::all(glm::greaterThan(middle, glm::vec3(0.0f))) &&
           glm::all(glm::lessThan(middle, glm::vec3(4.0f, 4.0f, 3.0f)));
  }

  // Rms of the difference over the rms, per cent.
  double ErrorPercent(const std::vector<glm::vec3>& radiosity, bool inside_alone) const {
    double error2 = 0.0;
    double size2 = 0.0;
    for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
      if (inside_alone && !IsInside(face)) continue;
      for (std::size_t i = face * kRegions; i < (face + 1) * kRegions; ++i) {
        const glm::vec3 apart = radiosity[i] - converged[i];
        error2 += glm::dot(apart, apart);
        size2 += glm::dot(converged[i], converged[i]);
      }
    }
    return 100.0 * std::sqrt(error2 / size2);
  }
};

// Arguments: rays of form factors, rays to the sky.
void SolveSixtyFourRegions(benchmark::State& state) {
  static const Room room;
  RegionRadiosityOptions options;
  options.sky_rays_per_patch = static_cast<int>(state.range(1));
  FaceLights lights;
  for (auto _ : state) {
    const PatchTransport transport =
        TransportOf(room.scene, static_cast<int>(state.range(0)), options.seed);
    lights = SolveRegions(room.scene, transport, options);
  }
  state.counters["patches"] = static_cast<double>(room.scene.mesh.triangles.size());
  state.counters["error_all_percent"] = room.ErrorPercent(lights.radiosity, false);
  state.counters["error_inside_percent"] = room.ErrorPercent(lights.radiosity, true);
}

// CPU time of all threads beside wall time: the first is sound on a busy machine too.
BENCHMARK(SolveSixtyFourRegions)
    ->Args({512, 16384})
    ->Args({1024, 65536})
    ->Args({1024, 131072})
    ->Args({2048, 131072})
    ->Args({2048, 262144})
    ->Args({4096, 1048576})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Iterations(1);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();

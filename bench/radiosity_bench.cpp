// What the radiosity of 64 sky regions costs, and how far it is from a converged one: 2000 patches
// of a room with a window, as bench/relight_bench.cpp has it; and how far probes lit by it are from
// ray-traced ones.
//
//   pleinair_radiosity_bench [Google Benchmark's options]
//
// The radiosities' reference (same patches, other rays: 8192 of form factors a face, 8 x 2^17 to
// the sky by SkyVisibility) takes a minute or two; its own noise is in the errors. The probes' is a
// path tracer that shares nothing but the ray queries; two traces give its noise, which is
// subtracted.

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include "bench/bench_room.h"
#include "relight/transport/region_radiosity.h"
#include "relight/transport/sky_visibility.h"
#include "relight/volume/probe_operator.h"
#include "tests/relight/reference_path_tracer.h"

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

  PatchScene scene = CutRoom(BenchRoom(), kBenchPatchSizeM);
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
           glm::all(glm::lessThan(middle, kRoomSize));
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
    ->Args({kBenchFormFactorRays, kBenchSkyRays})
    ->Args({1024, 131072})
    ->Args({2048, 131072})
    ->Args({2048, 262144})
    ->Args({4096, 1048576})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime()
    ->Iterations(1);

std::size_t FourBySixteen(const glm::dvec3& direction) {
  static const SkyRegions regions;
  return *regions.RegionOf(direction);
}

// Coefficients of what surfaces send to a point: [region * 9 + coefficient].
std::vector<glm::dvec3> TracedCoefficients(const Mesh& mesh,
                                           const glm::vec3& point,
                                           std::uint64_t seed) {
  constexpr int kDirections = 16384;
  constexpr int kPaths = 96;
  const RayCaster caster(mesh);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<ReferencePoint> hits;
  std::vector<glm::dvec3> albedos;
  std::vector<std::array<float, kProbeShCoefficients>> basis;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - 2.0 * (i + unit(random)) / kDirections;
    const double angle = 2.0 * std::numbers::pi * unit(random);
    const double radius = std::sqrt(std::max(0.0, 1.0 - z * z));
    const glm::vec3 direction(glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), z));
    const auto hit = caster.Intersect(point, direction);
    if (!hit) continue;
    const bool is_front = glm::dot(hit->geometric_normal, direction) <= 0.0f;
    hits.push_back({glm::dvec3(hit->position_m),
                    glm::dvec3(is_front ? hit->geometric_normal : -hit->geometric_normal)});
    albedos.emplace_back(mesh.materials[mesh.triangle_material[hit->triangle]].diffuse_albedo);
    basis.push_back(EvaluateShBasis9(direction));
  }
  const ReferenceLight light{.bins = Room::kRegions, .bin_of = FourBySixteen};
  const ReferenceOptions options{.paths = kPaths, .seed = seed};
  const std::vector<double> direct = ReferenceDirect(mesh, hits, light, options);
  const std::vector<glm::dvec3> indirect = ReferenceIndirect(mesh, hits, light, options);
  std::vector<glm::dvec3> coefficients(Room::kRegions * kProbeShCoefficients, glm::dvec3(0.0));
  for (std::size_t i = 0; i < hits.size(); ++i) {
    for (std::size_t region = 0; region < Room::kRegions; ++region) {
      const std::size_t k = i * Room::kRegions + region;
      // Radiance albedo / pi * irradiance, over 4 pi.
      const glm::dvec3 radiance = 4.0 / kDirections * albedos[i] * (direct[k] + indirect[k]);
      for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
        coefficients[region * kProbeShCoefficients + j] += double{basis[i][j]} * radiance;
      }
    }
  }
  return coefficients;
}

// At four places of the room, the precomputation's own settings.
void ProbesOfSixtyFourRegions(benchmark::State& state) {
  const Mesh mesh = BenchRoom();
  const PatchScene scene = CutRoom(mesh, kBenchPatchSizeM);
  const ProbeGrid grid = MakeProbeGrid({{1.0f, 1.5f, 0.7f}, {3.0f, 3.0f, 2.0f}}, {2, 1, 2});
  std::vector<std::vector<ShRgb>> of_region;
  for (auto _ : state) {
    RegionRadiosityOptions options;
    options.sky_rays_per_patch = kBenchSkyRays;
    const FaceLights lights =
        SolveRegions(scene, TransportOf(scene, kBenchFormFactorRays, options.seed), options);
    const ProbeOperator probes(scene, nullptr, grid, {.rays_per_probe = kBenchProbeRays});
    for (std::size_t region = 0; region < Room::kRegions; ++region) {
      of_region.push_back(probes.Apply({}, lights.OfLight(region), {}));
    }
  }
  double error2 = 0.0;
  double noise2 = 0.0;
  double size2 = 0.0;
  double sum = 0.0;
  double expected_sum = 0.0;
  for (std::size_t probe = 0; probe < grid.ProbeCount(); ++probe) {
    const auto one = TracedCoefficients(mesh, grid.PositionM(probe), 100 + probe);
    const auto other = TracedCoefficients(mesh, grid.PositionM(probe), 200 + probe);
    for (std::size_t k = 0; k < one.size(); ++k) {
      const std::size_t j = k % kProbeShCoefficients;
      const glm::dvec3 found(of_region[k / kProbeShCoefficients][probe][j]);
      const glm::dvec3 expected = 0.5 * (one[k] + other[k]);
      const glm::dvec3 noise = 0.5 * (one[k] - other[k]);
      error2 += glm::dot(found - expected, found - expected);
      noise2 += glm::dot(noise, noise);
      size2 += glm::dot(expected, expected);
      if (j == 0) sum += found.y;
      if (j == 0) expected_sum += expected.y;
    }
  }
  state.counters["error_percent"] = 100.0 * std::sqrt(std::max(0.0, error2 - noise2) / size2);
  state.counters["noise_percent"] = 100.0 * std::sqrt(noise2 / size2);
  state.counters["bias_percent"] = 100.0 * (sum / expected_sum - 1.0);
}
BENCHMARK(ProbesOfSixtyFourRegions)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();

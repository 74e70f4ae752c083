// What relighting costs in a frame, and when the sun has moved: environment map, irradiance volume
// by both routes, irradiance of an object's vertices; and, once a site, the probes' operator.
//
//   pleinair_relight_bench [Google Benchmark's options]

#include <array>
#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>
#include <glm/geometric.hpp>

#include "bench/bench_room.h"
#include "relight/transport/region_radiosity.h"
#include "relight/volume/environment.h"
#include "relight/volume/irradiance_volume.h"
#include "relight/volume/vertex_irradiance.h"
#include "scene/sky_shape.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair {
namespace {

constexpr LatLongSize kMapSize{1024, 512};
const glm::dvec3 kSun = glm::normalize(glm::dvec3(-0.5, 0.3, 0.6));

// A yard with 8^3 probes; a survey map shows all of it except the house's rear.
struct Site {
  PatchScene scene = Yard();
  Survey survey = SurveyOf(scene, {0.0, 0.0, 1.5}, kMapSize, kSun);
  ProbeGrid grid = MakeProbeGrid({{-2.0f, -2.0f, 0.0f}, {2.0f, 2.0f, 3.0f}}, glm::ivec3(8));
  ProbeOperator probes{scene, &survey, grid, {}};
  BasisLights basis;
  Lighting lighting;

  Site() {
    const auto sky = MakeUniformSkyShape();
    basis.environment = {EnvironmentOfSun(survey, kSun), EnvironmentOfSky(survey, 0, *sky)};
    basis.face_radiosity.assign(2, std::vector<glm::vec3>(scene.FaceCount(), glm::vec3(0.3f)));
    basis.sky_radiance.resize(2);
    for (const glm::vec3& direction : probes.SkyDirections()) {
      basis.sky_radiance[1].push_back(sky->Radiance(direction));
    }
    lighting.sun.irradiance_rgb = {800.0, 760.0, 700.0};
    lighting.sky = {{"uniform", {100.0, 120.0, 160.0}}};
  }
};

const Site& TheSite() {
  static const Site site;
  return site;
}

// A closed mesh of n faces has about n / 2 vertices. A ball of 1 m in the middle of the grid.
struct Object {
  std::vector<glm::vec3> positions_m, normals, irradiance;

  explicit Object(std::int64_t vertices) : irradiance(static_cast<std::size_t>(vertices)) {
    for (std::int64_t i = 0; i < vertices; ++i) {
      const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(vertices);
      const double azimuth = 2.399963 * static_cast<double>(i);
      const double r = std::sqrt(1.0 - z * z);
      normals.emplace_back(r * std::cos(azimuth), r * std::sin(azimuth), z);
      positions_m.push_back(glm::vec3(0.0f, 0.0f, 1.2f) + normals.back());
    }
  }
};

void EnvironmentMap(benchmark::State& state) {
  const Site& site = TheSite();
  RgbImage environment;
  for (auto _ : state) {
    SynthesiseEnvironment(site.basis.environment, site.lighting, environment);
    benchmark::DoNotOptimize(environment.pixels.data());
  }
}

void ProbesByFolding(benchmark::State& state) {
  const Site& site = TheSite();
  const FoldedVolume folded(site.probes, site.basis);
  IrradianceVolume volume;
  for (auto _ : state) {
    folded.Combine(site.lighting, {}, volume);
    benchmark::DoNotOptimize(volume.probes.data());
  }
}

void ProbesByMap(benchmark::State& state) {
  const Site& site = TheSite();
  RgbImage environment;
  SynthesiseEnvironment(site.basis.environment, site.lighting, environment);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        VolumeFromEnvironment(site.probes, site.basis, environment, site.lighting));
  }
}

void RefoldTheSun(benchmark::State& state) {
  const Site& site = TheSite();
  FoldedVolume folded(site.probes, site.basis);
  for (auto _ : state) folded.Refold(site.probes, site.basis, 0);
}

void EnvironmentOfAMovedSun(benchmark::State& state) {
  const Site& site = TheSite();
  for (auto _ : state) benchmark::DoNotOptimize(EnvironmentOfSun(site.survey, kSun));
}

// Arguments: vertices. A pose that is kept.
void VerticesOfAKeptPose(benchmark::State& state) {
  const Site& site = TheSite();
  IrradianceVolume volume;
  FoldedVolume(site.probes, site.basis).Combine(site.lighting, {}, volume);
  Object object(state.range(0));
  const VertexIrradiance points(volume, object.positions_m, object.normals);
  for (auto _ : state) {
    points.Evaluate(volume, object.irradiance);
    benchmark::DoNotOptimize(object.irradiance.data());
  }
}

// The same, set up at each call: an object that moves.
void VerticesOfANewPose(benchmark::State& state) {
  const Site& site = TheSite();
  IrradianceVolume volume;
  FoldedVolume(site.probes, site.basis).Combine(site.lighting, {}, volume);
  Object object(state.range(0));
  for (auto _ : state) {
    IrradianceAt(volume, object.positions_m, object.normals, object.irradiance);
    benchmark::DoNotOptimize(object.irradiance.data());
  }
}

// The indoor precomputation: a room with a window, 64 regions, 8^3 probes.
struct Room {
  PatchScene scene = CutRoom(BenchRoom(), kBenchPatchSizeM);
  ProbeGrid grid = MakeProbeGrid({{0.5f, 0.5f, 0.3f}, {3.5f, 3.5f, 2.7f}}, glm::ivec3(8));

  FoldedVolume Fold() const {
    GatherOptions gather;
    gather.rays_per_receiver = kBenchFormFactorRays;
    gather.from_exposed_parts = true;
    const PatchTransport transport(scene, gather);
    RegionRadiosityOptions options;
    options.sky_rays_per_patch = kBenchSkyRays;
    const FaceLights regions = SolveRegions(scene, transport, options);
    const ProbeOperator probes(scene, nullptr, grid, {.rays_per_probe = kBenchProbeRays});
    BasisLights basis;
    basis.environment.resize(1 + regions.lights);
    basis.sky_radiance.resize(1 + regions.lights);
    basis.face_radiosity.resize(1);  // No sun.
    for (std::size_t region = 0; region < regions.lights; ++region) {
      basis.face_radiosity.push_back(regions.OfLight(region));
    }
    return {probes, basis};
  }
};

void PrecomputeSixtyFourRegions(benchmark::State& state) {
  const Room room;
  for (auto _ : state) benchmark::DoNotOptimize(room.Fold());
  state.counters["patches"] = static_cast<double>(room.scene.mesh.triangles.size());
}

Lighting SixtyFourRegions() {
  Lighting lighting;
  lighting.sky.resize(64);
  for (SkyComponent& region : lighting.sky) region.irradiance_rgb = {100.0, 120.0, 160.0};
  return lighting;
}

void CombineSixtyFourRegions(benchmark::State& state) {
  const FoldedVolume folded = Room().Fold();
  const Lighting lighting = SixtyFourRegions();
  IrradianceVolume volume;
  for (auto _ : state) {
    folded.Combine(lighting, {}, volume);
    benchmark::DoNotOptimize(volume.probes.data());
  }
}

// For an object of 0.5 m in the middle of the room.
void CombineWhatAnObjectNeeds(benchmark::State& state) {
  const Room room;
  const FoldedVolume folded = room.Fold();
  const Lighting lighting = SixtyFourRegions();
  IrradianceVolume volume;
  folded.Combine(lighting, {}, volume);
  const std::array boxes{BoundingBox{{1.7f, 1.8f, 1.0f}, {2.2f, 2.3f, 1.5f}}};
  const std::vector<std::uint8_t> needed = ProbesNeededIn(room.grid, volume.valid, boxes);
  for (auto _ : state) {
    folded.Combine(lighting, needed, volume);
    benchmark::DoNotOptimize(volume.probes.data());
  }
}

// The worst case: a place that every region lights.
void SumSixtyFourLights(benchmark::State& state) {
  constexpr std::size_t kProbes = 512;
  BasisProbes basis(64, kProbes);
  ShRgb lit;
  lit.fill(glm::vec3(0.1f, 0.2f, 0.3f));
  for (std::size_t light = 0; light < 64; ++light) {
    basis.Set(light, std::vector<ShRgb>(kProbes, lit));
  }
  const std::vector<glm::vec3> weights(64, glm::vec3(1.0f, 2.0f, 3.0f));
  std::vector<ShRgb> sum(kProbes);
  for (auto _ : state) {
    basis.Sum(weights, {}, sum);
    benchmark::DoNotOptimize(sum.data());
  }
}

void MakeTheOperator(benchmark::State& state) {
  const Site& site = TheSite();
  for (auto _ : state) {
    benchmark::DoNotOptimize(ProbeOperator(site.scene, &site.survey, site.grid, {}));
  }
}

// CPU time of all threads beside wall time: the first is sound on a busy machine too.
void Configure(benchmark::internal::Benchmark* bench) {
  bench->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();
}
BENCHMARK(EnvironmentMap)->Apply(Configure);
BENCHMARK(ProbesByFolding)->Apply(Configure);
BENCHMARK(ProbesByMap)->Apply(Configure);
BENCHMARK(RefoldTheSun)->Apply(Configure);
BENCHMARK(EnvironmentOfAMovedSun)->Apply(Configure);
BENCHMARK(VerticesOfAKeptPose)->Arg(7500)->Arg(15000)->Apply(Configure);
BENCHMARK(VerticesOfANewPose)->Arg(7500)->Arg(15000)->Apply(Configure);
BENCHMARK(MakeTheOperator)->Apply(Configure);
BENCHMARK(PrecomputeSixtyFourRegions)->Apply(Configure);
BENCHMARK(CombineSixtyFourRegions)->Apply(Configure);
BENCHMARK(CombineWhatAnObjectNeeds)->Apply(Configure);
BENCHMARK(SumSixtyFourLights)->Apply(Configure);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();

// Times placing an object of 15 000 faces onto a point of 1000 triangles: in the open, and in a
// corner, out of which it has to slide.
//
//   pleinair_placement_bench [Google Benchmark's options]

#include <cmath>
#include <cstdint>

#include <benchmark/benchmark.h>
#include <glm/gtc/matrix_transform.hpp>

#include "objects/object_placement.h"
#include "tests/objects/placement_stage.h"

namespace pleinair {
namespace {

using namespace placement_stage;

// A floor of 22 x 22 squares, with two walls on it.
Mesh Yard() {
  Builder builder;
  for (int x = -11; x < 11; ++x) {
    for (int y = -11; y < 11; ++y) {
      const glm::vec3 at(static_cast<float>(x), static_cast<float>(y), 0.0f);
      builder.Quad(
          "floor", at, at + glm::vec3(1, 0, 0), at + glm::vec3(1, 1, 0), at + glm::vec3(0, 1, 0));
    }
  }
  builder.Box("wall", {-10, 3, 0}, {10, 3.2f, 4});
  builder.Box("wall", {2, -3, 0}, {2.2f, 3, 4});
  return builder.Done();
}

void Place(benchmark::State& state, const glm::dvec3& towards) {
  const Mesh mesh = Yard();
  const RayCaster caster(mesh);
  const PlaceableObject object(SphereMesh(0.5f, 75, 100));
  const glm::dvec3 eye(0.0, 0.0, 1.7);
  const auto point = SurfaceAlong(caster, mesh, eye, glm::normalize(towards - eye));
  const glm::dmat4 pose =
      glm::rotate(glm::dmat4(1.0), 2.1, glm::normalize(glm::dvec3(0.3, -0.8, 0.4)));
  for ([[maybe_unused]] const auto step : state) {
    const auto resting = RestOn(object, pose, *point, caster, mesh);
    if (!resting) return state.SkipWithError("no room");
    benchmark::DoNotOptimize(resting);
  }
}

BENCHMARK_CAPTURE(Place, in_the_open, glm::dvec3(-3.0, 0.0, 0.0))->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Place, in_a_corner, glm::dvec3(1.7, 2.7, 0.0))->Unit(benchmark::kMicrosecond);

void Prepare(benchmark::State& state) {
  const Mesh sphere = SphereMesh(0.5f, 75, 100);
  for ([[maybe_unused]] const auto step : state) {
    benchmark::DoNotOptimize(PlaceableObject(sphere));
  }
}
BENCHMARK(Prepare)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();

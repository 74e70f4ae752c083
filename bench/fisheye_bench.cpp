// Times what a fish-eye source does with every picture: disc, region averages, the sky's shape.
#include <cstdint>
#include <vector>

#include <benchmark/benchmark.h>

#include "estimation/fisheye_sky.h"
#include "estimation/region_averages.h"
#include "tests/estimation/synthetic_fisheye.h"

namespace pleinair {
namespace {

using testing::FisheyePicture;
using testing::MakeFisheyePicture;
using testing::SkyCamera;

void ReadPicture(benchmark::State& state, bool with_shape) {
  FisheyePicture picture;
  picture.side_px = static_cast<int>(state.range(0));
  const RgbImage radiance = MakeFisheyePicture(picture);
  FisheyeSky sky(SkyCamera(picture.side_px), SkyRegions());
  for (auto _ : state) {
    sky.Read(radiance, picture.sun_direction_enu, kMeanSunAngularRadiusRad);
    if (with_shape) benchmark::DoNotOptimize(sky.Shape());
  }
}
// The averages alone, a disc of pixels replaced.
void AverageRegions(benchmark::State& state) {
  FisheyePicture picture;
  picture.side_px = static_cast<int>(state.range(0));
  const RgbImage radiance = MakeFisheyePicture(picture);
  const FisheyePixelTable table = MakeFisheyePixelTable(SkyCamera(picture.side_px));
  RegionAverages averages(table, SkyRegions());
  const auto middle = static_cast<std::uint32_t>(
      table.direction_world.Index(picture.side_px / 2, picture.side_px / 2));
  const std::vector<std::uint32_t> disc{middle, middle + 1, middle + 2, middle + 3};
  for (auto _ : state) {
    averages.Average(radiance, disc, glm::vec3(1.0f));
    benchmark::DoNotOptimize(averages.Radiance().data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(AverageRegions)->Arg(512)->Unit(benchmark::kMicrosecond);

BENCHMARK_CAPTURE(ReadPicture, RegionsAndDisc, false)->Arg(512)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(ReadPicture, WithShape, true)->Arg(512)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();

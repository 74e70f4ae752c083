// Times what a fish-eye source does with every picture: disc, region averages, the sky's shape.
#include <benchmark/benchmark.h>

#include "estimation/fisheye_sky.h"
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
BENCHMARK_CAPTURE(ReadPicture, RegionsAndDisc, false)->Arg(512)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(ReadPicture, WithShape, true)->Arg(512)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace pleinair

BENCHMARK_MAIN();

// The room of the indoor benchmarks: 5 x 4 x 3 m with a window of 1.8 x 1.4 m, some 2000 patches.
#pragma once

#include "tests/relight/window_room.h"
#include "tests/relight/window_rooms.h"

namespace pleinair {

inline constexpr double kBenchPatchSizeM = 0.52;
inline constexpr int kBenchFormFactorRays = 1024;
inline constexpr int kBenchSkyRays = 98304;
inline constexpr int kBenchProbeRays = 4096;

inline Mesh BenchRoom() {
  Mesh mesh = SheetRoom({kSouthHole});
  mesh.materials[0].diffuse_albedo = {0.7f, 0.6f, 0.5f};
  return mesh;
}

}  // namespace pleinair

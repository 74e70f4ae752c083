// What each face gets straight from each region of the sky.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "relight/progress.h"
#include "relight/transport/face_points.h"
#include "relight/transport/patch_scene.h"
#include "scene/sky_regions.h"

namespace pleinair::internal {

// Neighbouring patches, both sides, that are looked at together: dealing faces out in multiples of
// it wastes nothing.
inline constexpr std::size_t kFacesPerGroup = 32;
// With fewer regions than this there is nothing to gain from passing over some.
inline constexpr std::size_t kLeastRegionsToSkip = 32;
// Multiples of these, with i / n, fill four dimensions evenly: powers of the inverse of the root of
// x^4 = x + 1 (Roberts 2018). Square roots of 2, 3 and 5 in their place leave three times the
// error.
inline constexpr std::array<double, 3> kLattice = {
    0.8191725133961645, 0.6710436067037893, 0.5497004779019703};

// Regions of the sky, and the rays that look for them.
struct RegionRays {
  const SkyRegions& regions;
  // Shared by the regions, at least one each, evenly over region and face. Most are not cast.
  int per_face = 1;
  std::uint64_t seed = 0;
};

// [first, last).
struct FaceRange {
  std::size_t first = 0;
  std::size_t last = 0;
};

// Irradiance of the faces from unit radiance of each region: [face - faces.first][region].
//
// Regions, and cells of some 16 rays, are left out where a few rays of neighbouring
// faces that face the same way show all or nothing of them and of those around them. So in a room
// the rays that are cast go through the windows.
//
// Accuracy  a room with a window, 64 regions, 2400 patches: bench/radiosity_bench.cpp.
// Threads   the result does not depend on their number, nor on how faces are dealt out.
// Throws    std::invalid_argument for points of other faces than the scene's, or less than 1 ray.
std::vector<float> RegionIrradiance(const PatchScene& scene,
                                    const FacePoints& points,
                                    const RegionRays& rays,
                                    const FaceRange& faces,
                                    const Progress& progress);

}  // namespace pleinair::internal

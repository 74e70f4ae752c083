// Radiosity of a scene for each region of the sky (grosch-2007, section 5.1).
#pragma once

#include <cstddef>
#include <cstdint>

#include "relight/transport/patch_scene.h"
#include "relight/transport/rank_group.h"
#include "relight/transport/transport.h"
#include "scene/sky_regions.h"

namespace pleinair {

struct RegionRadiosityOptions {
  SkyRegions regions{};
  // Over the sky as each patch sees it, shared by the regions, at least one each; those that
  // neighbours say are hidden or open are not cast. Converged: many.
  int sky_rays_per_patch = 262144;
  std::uint64_t seed = 1;
  // A missing share of a thousandth is far below the noise of the rays.
  SolveOptions solve{.tolerance = 1e-4};
  // Ranks that share the work: each casts rays to the sky for some faces, and solves some blocks
  // of lights. Null: this process does all. The result is the same, bit for bit.
  RankGroup* ranks = nullptr;
};

// Light of the faces for unit radiance of each region. `transport` is made from_exposed_parts.
//
// Accuracy  2400 patches of a room with a window, 64 regions, 2048 rays of form factors, against
//           more rays: 0.2 % rms over all faces, 1 % over those inside the room, of which 0.6 % is
//           the form factors' (bench/radiosity_bench.cpp).
// Memory    see RadiosityBytes.
// Throws    std::invalid_argument for a transport without exposed parts or of another scene, or
//           options that make no sense, naming the field.
FaceLights SolveRegions(const PatchScene& scene,
                        const PatchTransport& transport,
                        const RegionRadiosityOptions& options);

}  // namespace pleinair

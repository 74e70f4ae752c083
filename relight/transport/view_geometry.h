// Which surface each pixel of a view shows.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/pixel_blocks.h"
#include "relight/transport/view_rays.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// Which blocks are cast, once their corners have been: an entry a block, 0 where it is left out.
using ChooseBlocks = std::function<std::vector<std::uint8_t>(const PixelBlocks& blocks)>;

// Casts the view's rays: sets region_names, region, position_world_m and normal_world of `view`,
// and the triangle's side that each pixel shows (PatchScene::kSky where none). Keeps the images'
// memory.
//
// With `block_px` above 1 the corners of blocks are cast first. Where a block's four corners show
// one plane, its other pixels are assumed to show it too, and their rays are spared. Things thinner
// than a block may be missed, and a pixel may get the neighbouring triangle of a plane. Returns
// which blocks these are.
//
// With `choose`, pixels of blocks that are left out show nothing. `before` is then the last call's
// result with these images.
PlanarBlocks CastGeometry(const PatchScene& scene,
                          const ViewRays& rays,
                          int block_px,
                          SurfaceView& view,
                          Image<std::int32_t>& side,
                          const ChooseBlocks& choose = nullptr,
                          const PlanarBlocks& before = {});

// Blocks of which every pixel shows the plane of the first, for a view seen from `eye_m`.
PlanarBlocks FindPlanarBlocks(const SurfaceView& view, const glm::vec3& eye_m, int block_px);

}  // namespace pleinair

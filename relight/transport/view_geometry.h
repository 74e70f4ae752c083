// Which surface each pixel of a view shows.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/pixel_blocks.h"
#include "relight/transport/view_rays.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// Casts the view's rays: sets region_names, region, position_world_m and normal_world of `view`,
// and the triangle's side that each pixel shows (PatchScene::kSky where none). Keeps the images'
// memory.
//
// With `block_px` above 1 the corners of blocks are cast first. Where a block's four corners show
// one plane, its other pixels are assumed to show it too, and their rays are spared. Things thinner
// than a block may be missed, and a pixel may get the neighbouring triangle of a plane. Returns
// which blocks these are.
PlanarBlocks CastGeometry(const PatchScene& scene,
                          const ViewRays& rays,
                          int block_px,
                          SurfaceView& view,
                          Image<std::int32_t>& side);

// Blocks of which every pixel shows the plane of the first, for a view seen from `eye_m`.
PlanarBlocks FindPlanarBlocks(const SurfaceView& view, const glm::vec3& eye_m, int block_px);

}  // namespace pleinair

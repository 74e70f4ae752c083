// Which blocks of a view's pixels are looked at, judged by what their corners show.
#pragma once

#include <cstdint>
#include <vector>

#include "relight/transport/pixel_blocks.h"
#include "relight/view_part.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// `view` has its camera, and the geometry of the blocks' corners. Things before the surfaces that
// corners show, and thinner than a block, may be missed.
// Shape  side: the triangle's side that each pixel shows, PatchScene::kSky where none. Returns an
//        entry a block, 1 where it is looked at.
std::vector<std::uint8_t> LookedAtBlocks(const ViewPart& part,
                                         const PixelBlocks& blocks,
                                         const SurfaceView& view,
                                         const Image<std::int32_t>& side);

}  // namespace pleinair

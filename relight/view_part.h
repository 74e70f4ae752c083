// Which pixels of a view somebody looks at: the others need not be made.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/transport/pixel_blocks.h"
#include "scene/image.h"
#include "scene/pixel_rect.h"

namespace pleinair {

struct ViewPart {
  // Pixels that are looked at in any case; may reach beyond the picture.
  std::vector<PixelRect> rects;
  // Whether pixels are looked at that show a place: a triangle's side, and a point on it. Empty:
  // none are. Called from several threads.
  std::function<bool(std::int32_t side, const glm::vec3& place_m)> looks_at;
};

// Blocks with pixels that are looked at, judged by the places that the blocks' corners show. What
// is thinner than a block may be missed. Pixels that show such a place have blocks around them for
// at least 8 px, for what is compared with its surroundings.
// Shape  an entry a block, 1 where it is.
std::vector<std::uint8_t> BlocksLookedAt(const ViewPart& part,
                                         const PixelBlocks& blocks,
                                         const Image<std::int32_t>& side,
                                         const Image<glm::vec3>& position_m);

}  // namespace pleinair

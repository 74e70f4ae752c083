// Where the objects' changes are computed: which pixels of a view share a receiver, and how fine a
// lattice over the real faces is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "objects/internal/object_cone.h"
#include "relight/transport/patch_scene.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// Sides of the blocks that share a receiver, in pixels: odd, so that a pixel is in the middle.
inline constexpr std::array<int, 4> kInfluenceBlocksPx{1, 3, 7, 15};

// How the pixels of a view are served.
struct PixelPlan {
  Gray8Image size;     // 0 where no object can matter, else 1 + the index of its block's side.
  Gray8Image covered;  // Where a size is: an object hides the surface that the view describes.
};

// `least_share` and `coarseness` as in ObjectInfluenceOptions.
PixelPlan PlanPixels(const PatchScene& objects,
                     const std::vector<std::optional<ObjectBounds>>& bounds,
                     const SurfaceView& view,
                     float least_share,
                     float coarseness);

// Pixels that may hold a receiver for blocks of size `size`: those of the blocks around any pixel
// that has that size.
Gray8Image Candidates(const PixelPlan& plan, std::size_t size);

// Into how many parts the edges of each face are cut for a lattice, 0 where no object can matter.
std::vector<std::uint16_t> PartsOfFaces(const PatchScene& real,
                                        const std::vector<std::optional<ObjectBounds>>& bounds,
                                        float least_share,
                                        float coarseness,
                                        double least_spacing);

}  // namespace pleinair

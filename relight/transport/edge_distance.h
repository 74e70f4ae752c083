// How far each pixel of a view is from where the model of its light jumps.
#pragma once

#include <glm/vec3.hpp>

#include "relight/transport/pixel_blocks.h"
#include "scene/image.h"
#include "scene/surface_view.h"

namespace pleinair {

// 255 at pixels on either side of a jump of region or plane, else 0. `origin_m`: where the view is
// taken from.
Gray8Image MeshEdges(const SurfaceView& view, const glm::vec3& origin_m, bool wraps_x);

// The same of a view that does not wrap: among planar blocks pixels are not looked at. Keeps the
// memory of `edges`.
void MeshEdgesInBlocks(const SurfaceView& view,
                       const glm::vec3& origin_m,
                       const PlanarBlocks& planar,
                       Gray8Image& edges);

// Sets to 255 in `edges` the pixels on either side of a jump of `sun_visibility`, and in penumbrae.
void AddShadowEdges(const SurfaceView& view,
                    const GrayImage& sun_visibility,
                    bool wraps_x,
                    Gray8Image& edges);

// Euclidean distance to the nearest edge pixel's centre, 0 on it. Without any edge, the longer side
// of the picture.
GrayImage DistanceTo(const Gray8Image& edges, bool wraps_x);

// The same of a view that does not wrap, where what lies around the picture counts as edge. Keeps
// the memory of `distance_px`.
void DistanceToEdgeOrBorder(const Gray8Image& edges, GrayImage& distance_px);

}  // namespace pleinair

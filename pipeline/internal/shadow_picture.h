// A frame's pixels that shadows can be read from.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pipeline/internal/shadow_evidence.h"
#include "scene/frame.h"
#include "scene/mesh.h"

namespace pleinair {

// Per triangle of `mesh`: 1 where its group or material is among `regions`; no regions: all.
// Throws std::invalid_argument for an empty mesh, or a region that is neither.
std::vector<std::uint8_t> UsableTriangles(const Mesh& mesh, std::span<const std::string> regions);

// Those of `surfaces` that `frame` shows with a usable value; clipped ones are surely lit where lit
// and shaded differ. Without shares.
ShadowPicture MakeShadowPicture(const Frame& frame, std::span<const ShadowPixel> surfaces);

}  // namespace pleinair

// Triangles cut so that faces of one colour each show what a texture shows.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "scene/internal/mesh_mending.h"
#include "scene/internal/textured_material.h"

namespace pleinair {

// How often triangles are worth being cut into four so that none goes over more than a few texels,
// or from one vertex colour to a very different one; `most` triangles may come out.
// `sources` gives a triangle's material.
int WorthwhileCuts(std::span<const LooseTriangle> triangles,
                   const MaterialList& sources,
                   std::size_t most);

// Each triangle in four, at the middles of its edges: neighbours stay joined.
std::vector<LooseTriangle> CutIntoFour(std::span<const LooseTriangle> triangles);

}  // namespace pleinair

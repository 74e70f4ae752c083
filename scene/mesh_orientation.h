// Determines which side of a mesh is outside.
#pragma once

#include <cstdint>

#include "scene/mesh.h"

namespace pleinair {

// Reverses winding and normals of the closed parts of a virtual object that are inside out
// (negative volume). Returns the number of those triangles. Parts are triangles joined over edges
// of equal position. Open parts are not changed: they have no outside. Neither is a part's normal
// that already points against its winding, outwards.
//
// For objects only: a room that is seen from inside is rightly inside out. The inner wall of a
// hollow body is turned too, but is never visible.
std::int64_t TurnClosedPartsOutward(Mesh& mesh);

}  // namespace pleinair

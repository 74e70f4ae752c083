// Which side of a mesh is outside.
#pragma once

#include <cstdint>

#include "scene/mesh.h"

namespace pleinair {

// Turns the closed parts of a virtual object that are inside out (negative volume), winding and
// normals, and returns how many triangles that were. Parts are triangles joined over edges of equal
// position. Open parts stay as they are: they have no outside. So does a part's normal that already
// points against its winding, outwards.
//
// For objects alone: a room that is seen from inside is rightly inside out, and a hollow body's
// inner wall, which this would turn too, is never seen.
std::int64_t TurnClosedPartsOutward(Mesh& mesh);

}  // namespace pleinair

// Several small triangles to a patch.
#pragma once

#include "relight/transport/patch_refinement.h"
#include "relight/transport/patch_scene.h"

namespace pleinair::internal {

// Joins triangles that were not cut and whose edges are short beside `target`. Joined are those of
// one group and material that look along the same axis, with their middles in one cell of a grid.
// Its cells are about as large as other patches. What has hardly an area beside others in its cell
// goes with the largest there, whichever way it looks. Neither neighbours nor a clean mesh are
// needed: what lies in holes, slivers and noise is joined as well. Brings a patch's triangles in a
// row; empty, and the order as it was, where no two are joined.
//
// `made`: triangles from this source on are not the mesh's own, and stay apart from it.
PatchesOfTriangles JoinSmallTriangles(const TargetLength& target,
                                      std::uint32_t made,
                                      RefinedMesh& refined);

}  // namespace pleinair::internal

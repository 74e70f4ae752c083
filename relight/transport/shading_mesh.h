// An object's mesh, fine enough for light that is worked out at its vertices.
#pragma once

#include <cstddef>

#include "scene/mesh.h"

namespace pleinair {

struct ShadingMeshOptions {
  // Longest edge, as a share of the diagonal of the mesh's bounding box: light that is worked out
  // at the corners of a pedestal's side would carry the dark of its joints all over it. > 0.
  double longest_edge = 0.04;
  // Edges may stay longer where more triangles than so many times as many as there were would come
  // out, and more than kFewTriangles. >= 1.
  double most_growth = 2.0;
  static constexpr std::size_t kFewTriangles = 6000;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// `mesh` with its long edges cut; materials, groups and normals are the source's, which it needs.
// A mesh that is fine enough comes back as it is, but for triangles without area. Materials by
// place have the means over the new triangles, so that light that goes from them is as finely
// coloured as it is worked out, whatever is drawn.
Mesh MakeShadingMesh(const Mesh& mesh, const ShadingMeshOptions& options = {});

}  // namespace pleinair

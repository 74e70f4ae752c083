// An object's mesh, fine enough for light that is computed at its vertices.
#pragma once

#include <cstddef>

#include "scene/mesh.h"

namespace pleinair {

struct ShadingMeshOptions {
  // Longest edge, as a share of the diagonal of the mesh's bounding box; > 0. With long edges,
  // light at the corners of a pedestal's side would spread the dark of its joints over all of it.
  double longest_edge = 0.04;
  // Edges may stay longer where more triangles than so many times as many as there were would come
  // out, and more than kFewTriangles. >= 1.
  double most_growth = 2.0;
  static constexpr std::size_t kFewTriangles = 6000;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// `mesh` with its long edges cut; materials, groups and normals are the source's, which it needs. A
// mesh that is fine enough comes back as it is, but for triangles without area. Materials by place
// have the means over the new triangles, so that the colours of light from them are as fine as that
// light is computed, whatever is drawn.
Mesh MakeShadingMesh(const Mesh& mesh, const ShadingMeshOptions& options = {});

}  // namespace pleinair

#include "relight/transport/shading_mesh.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "relight/transport/patch_refinement.h"
#include "scene/textured_material.h"

namespace pleinair {

void ShadingMeshOptions::Validate() const {
  if (!(longest_edge > 0.0) || !std::isfinite(longest_edge)) {
    throw std::invalid_argument(std::string("ShadingMeshOptions::longest_edge is ") +
                                std::to_string(longest_edge) + ": expected a number above 0");
  }
  if (!(most_growth >= 1.0) || !std::isfinite(most_growth)) {
    throw std::invalid_argument(std::string("ShadingMeshOptions::most_growth is ") +
                                std::to_string(most_growth) + ": expected at least 1");
  }
}

Mesh MakeShadingMesh(const Mesh& mesh, const ShadingMeshOptions& options) {
  options.Validate();
  if (mesh.triangles.empty()) return mesh;
  const BoundingBox box = BoundingBoxOf(mesh);
  const double diagonal_m = glm::distance(glm::dvec3(box.lower_m), glm::dvec3(box.upper_m));
  if (!(diagonal_m > 0.0)) return mesh;
  const auto grown =
      static_cast<std::size_t>(options.most_growth * static_cast<double>(mesh.triangles.size()));
  const std::size_t most = std::max(grown, ShadingMeshOptions::kFewTriangles);
  // Each step has half as many triangles; at the entire diagonal no edge is cut.
  for (double edge_m = options.longest_edge * diagonal_m; edge_m < diagonal_m;
       edge_m *= std::sqrt(2.0)) {
    auto refined = TryRefineMesh(
        mesh, [&](const glm::vec3&) { return edge_m; }, most);
    if (!refined) continue;
    TakeMeansOverTriangles(refined->mesh);
    return std::move(refined->mesh);
  }
  return mesh;
}

}  // namespace pleinair

// The edges of a mesh that may be visible in a picture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

// One edge; world frame, metres.
struct MeshEdge {
  glm::dvec3 from_m{0.0};
  glm::dvec3 to_m{0.0};
  // Visible from anywhere: a crease, an end of the surface, or a border of two materials. Otherwise
  // visible only as an outline, from where one of the two faces is seen from behind.
  bool is_sharp = true;
  // By winding; for the two faces of an edge that is not sharp.
  glm::dvec3 normal_a{0.0};
  glm::dvec3 normal_b{0.0};

  bool IsOutlineFrom(const glm::dvec3& eye_m) const;
};

// Vertices of equal position are merged. Edges between faces of one material that bend by less than
// 2 degrees are left out; from 25 degrees on they are creases. An edge of a single face is left out
// where the surface continues beyond it in the same plane and material (a T-junction), which `rays`
// of the same mesh determine.
std::vector<MeshEdge> EdgesOf(const Mesh& mesh, const RayCaster& rays);

// The same with sharp edges that continue each other in a line, to 2 degrees, as one: how finely a
// mesh is cut changes nothing.
std::vector<MeshEdge> JoinedEdges(std::span<const MeshEdge> edges);

// A mesh by its edges, and the rays that find which of them it hides. Keeps references to both.
struct EdgeModel {
  std::span<const MeshEdge> edges;
  const RayCaster& rays;
};

}  // namespace pleinair

// The edges of a mesh that a picture may show.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

struct MeshEdge {
  glm::dvec3 from_m{0.0};
  glm::dvec3 to_m{0.0};
  // Seen from anywhere: a crease, an end of the surface, or where two materials meet. Otherwise
  // only as an outline, from where one of the two faces is seen from behind.
  bool is_sharp = true;
  // By winding; of the two faces of an edge that is not sharp.
  glm::dvec3 normal_a{0.0};
  glm::dvec3 normal_b{0.0};

  bool IsOutlineFrom(const glm::dvec3& eye_m) const;
};

// Vertices at one place are one vertex. Edges between faces that bend by less than 2 degrees, and
// have one material, are none; from 25 degrees on they are creases. An edge of one face alone is
// none where the surface goes on beyond it in the same plane and material (a T-junction), which
// `rays` of the same mesh show.
std::vector<MeshEdge> EdgesOf(const Mesh& mesh, const RayCaster& rays);

}  // namespace pleinair

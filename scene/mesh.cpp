#include "scene/mesh.h"

#include <cmath>
#include <stdexcept>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace pleinair {

BoundingBox BoundingBoxOf(const Mesh& mesh) {
  if (mesh.Empty()) throw std::invalid_argument("bounding box: the mesh has no triangle");
  const glm::vec3 first = mesh.positions_m[mesh.triangles.front().x];
  BoundingBox box{first, first};
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3& position_m = mesh.positions_m[triangle[corner]];
      box.lower_m = glm::min(box.lower_m, position_m);
      box.upper_m = glm::max(box.upper_m, position_m);
    }
  }
  return box;
}

std::array<glm::vec3, 8> CornersOf(const BoundingBox& box) {
  std::array<glm::vec3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] = {(i & 1) != 0 ? box.upper_m.x : box.lower_m.x,
                  (i & 2) != 0 ? box.upper_m.y : box.lower_m.y,
                  (i & 4) != 0 ? box.upper_m.z : box.lower_m.z};
  }
  return corners;
}

Mesh TransformMesh(const glm::dmat4& target_from_mesh, const Mesh& mesh) {
  const glm::dmat3 linear(target_from_mesh);
  const double determinant = glm::determinant(linear);
  bool finite = true;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      finite = finite && std::isfinite(target_from_mesh[column][row]);
    }
  }
  const bool affine = target_from_mesh[0].w == 0.0 && target_from_mesh[1].w == 0.0 &&
                      target_from_mesh[2].w == 0.0 && target_from_mesh[3].w == 1.0;
  if (!affine || !finite || !std::isfinite(determinant) || determinant == 0.0) {
    throw std::invalid_argument(
        "mesh transform: must be affine (last row 0 0 0 1), finite and invertible");
  }
  const glm::dmat3 normal_from_normal = glm::transpose(glm::inverse(linear));

  Mesh moved = mesh;
  for (glm::vec3& position_m : moved.positions_m) {
    position_m = glm::vec3(target_from_mesh * glm::dvec4(position_m, 1.0));
  }
  for (glm::vec3& normal : moved.normals) {
    normal = glm::vec3(glm::normalize(normal_from_normal * glm::dvec3(normal)));
  }
  if (determinant < 0.0) {
    for (glm::uvec3& triangle : moved.triangles) std::swap(triangle.y, triangle.z);
    for (TriangleColours& colours : moved.triangle_colours) {
      std::swap(colours.texture_uv[1], colours.texture_uv[2]);
      std::swap(colours.vertex_colour[1], colours.vertex_colour[2]);
    }
  }
  return moved;
}

glm::vec3 TriangleNormal(const Mesh& mesh, std::uint32_t triangle) {
  const glm::uvec3 corners = mesh.triangles[triangle];
  const glm::dvec3 a = mesh.positions_m[corners.x];
  const glm::dvec3 normal = glm::cross(glm::dvec3(mesh.positions_m[corners.y]) - a,
                                       glm::dvec3(mesh.positions_m[corners.z]) - a);
  const double length = glm::length(normal);
  return length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0.0f);
}

}  // namespace pleinair

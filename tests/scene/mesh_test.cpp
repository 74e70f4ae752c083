#include "scene/mesh.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "tests/scene/box_mesh.h"

namespace pleinair::mesh_test {
namespace {

double SignedVolume(const Mesh& mesh) {
  double six_volumes = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    six_volumes +=
        glm::dot(glm::dvec3(mesh.positions_m[t.x]),
                 glm::cross(glm::dvec3(mesh.positions_m[t.y]), glm::dvec3(mesh.positions_m[t.z])));
  }
  return six_volumes / 6.0;
}

TEST(Mesh, BoundingBoxIsThatOfTheTriangles) {
  Mesh mesh = BoxMesh({-1.0f, 2.0f, -3.0f}, {4.0f, 5.0f, 6.0f});
  mesh.positions_m.push_back({100.0f, 100.0f, 100.0f});  // In no triangle.
  mesh.normals.push_back({0.0f, 0.0f, 1.0f});
  const BoundingBox box = BoundingBoxOf(mesh);
  EXPECT_EQ(box.lower_m, glm::vec3(-1.0f, 2.0f, -3.0f));
  EXPECT_EQ(box.upper_m, glm::vec3(4.0f, 5.0f, 6.0f));
  EXPECT_THROW(BoundingBoxOf(Mesh{}), std::invalid_argument);
}

// Volumes change by the determinant; a mirror keeps the outside outside.
TEST(Mesh, TransformsKeepTheOutsideOutside) {
  const Mesh box = BoxMesh({0.0f, 0.0f, 0.0f}, {1.0f, 2.0f, 3.0f});
  EXPECT_NEAR(SignedVolume(box), 6.0, 1e-6);
  const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), {5.0, -6.0, 7.0});
  EXPECT_NEAR(SignedVolume(TransformMesh(moved, box)), 6.0, 1e-4);
  const glm::dmat4 mirrored = glm::scale(moved, {-2.0, 1.0, 1.5});
  EXPECT_NEAR(SignedVolume(TransformMesh(mirrored, box)), 18.0, 1e-3);
}

// A slope squeezed to a tenth of its height: its normal goes by the inverse transpose.
TEST(Mesh, NormalsStayNormalToTheirSurface) {
  Mesh mesh;
  mesh.positions_m = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 1.0f}, {0.0f, 1.0f, 0.0f}};
  mesh.triangles = {{0, 1, 2}};
  mesh.normals.assign(3, TriangleNormal(mesh, 0));
  for (const glm::dvec3& scale : {glm::dvec3(1.0, 1.0, 0.1), glm::dvec3(-1.0, 2.0, 0.1)}) {
    const Mesh squeezed = TransformMesh(glm::scale(glm::dmat4(1.0), scale), mesh);
    const glm::vec3 facet = TriangleNormal(squeezed, 0);
    for (const glm::vec3& normal : squeezed.normals) {
      EXPECT_NEAR(glm::distance(normal, facet), 0.0f, 1e-6f);
      EXPECT_NEAR(glm::length(normal), 1.0f, 1e-6f);
    }
  }
}

TEST(Mesh, RefusesTransformsThatAreNoPlacement) {
  const Mesh box = BoxMesh(glm::vec3(0.0f), glm::vec3(1.0f));
  EXPECT_THROW(TransformMesh(glm::dmat4(0.0), box), std::invalid_argument);
  EXPECT_THROW(TransformMesh(glm::scale(glm::dmat4(1.0), {1.0, 1.0, 0.0}), box),
               std::invalid_argument);
  glm::dmat4 projective(1.0);
  projective[0].w = 0.5;
  EXPECT_THROW(TransformMesh(projective, box), std::invalid_argument);
  glm::dmat4 unknown(1.0);
  unknown[3].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(TransformMesh(unknown, box), std::invalid_argument);
}

TEST(Mesh, TriangleWithoutAreaHasNoNormal) {
  Mesh mesh;
  mesh.positions_m = {{0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, {2.0f, 2.0f, 2.0f}};
  mesh.triangles = {{0, 1, 2}, {0, 0, 1}};
  EXPECT_EQ(TriangleNormal(mesh, 0), glm::vec3(0.0f));
  EXPECT_EQ(TriangleNormal(mesh, 1), glm::vec3(0.0f));
}

}  // namespace
}  // namespace pleinair::mesh_test

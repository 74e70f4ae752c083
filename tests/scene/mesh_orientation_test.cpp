#include "scene/mesh_orientation.h"

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace pleinair::mesh_orientation_test {
namespace {

// A closed tetrahedron around `centre`, normals pointing away from it.
void AddTetrahedron(const glm::vec3& centre, bool is_inside_out, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const glm::vec3& corner :
       {glm::vec3(1, 1, 1), glm::vec3(-1, -1, 1), glm::vec3(-1, 1, -1), glm::vec3(1, -1, -1)}) {
    mesh.positions_m.push_back(centre + corner);
    mesh.normals.push_back((is_inside_out ? -1.0f : 1.0f) * glm::normalize(corner));
  }
  for (glm::uvec3 t : {glm::uvec3(0, 2, 1), {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    if (is_inside_out) std::swap(t.y, t.z);
    mesh.triangles.push_back(t + first);
  }
}

void ExpectAllOutward(const Mesh& mesh, const glm::vec3& centre, std::size_t first_triangle) {
  for (std::size_t t = first_triangle; t < first_triangle + 4; ++t) {
    const glm::vec3 away = mesh.positions_m[mesh.triangles[t].x] - centre;
    EXPECT_GT(glm::dot(TriangleNormal(mesh, static_cast<std::uint32_t>(t)), away), 0.0f);
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.triangles[t][corner];
      EXPECT_GT(glm::dot(mesh.normals[vertex], mesh.positions_m[vertex] - centre), 0.0f);
    }
  }
}

TEST(TurnClosedPartsOutward, TurnsOnlyWhatIsInsideOut) {
  Mesh mesh;
  AddTetrahedron({0, 0, 0}, false, mesh);
  AddTetrahedron({5, 0, 0}, true, mesh);
  EXPECT_EQ(TurnClosedPartsOutward(mesh), 4);
  ExpectAllOutward(mesh, {0, 0, 0}, 0);
  ExpectAllOutward(mesh, {5, 0, 0}, 4);
  EXPECT_EQ(TurnClosedPartsOutward(mesh), 0);
}

TEST(TurnClosedPartsOutward, KeepsNormalsThatPointOutwardAlready) {
  Mesh mesh;
  AddTetrahedron({0, 0, 0}, true, mesh);
  for (glm::vec3& normal : mesh.normals) normal = -normal;
  EXPECT_EQ(TurnClosedPartsOutward(mesh), 4);
  ExpectAllOutward(mesh, {0, 0, 0}, 0);
}

TEST(TurnClosedPartsOutward, LeavesOpenPartsAsTheyAre) {
  Mesh mesh;
  AddTetrahedron({0, 0, 0}, true, mesh);
  mesh.triangles.pop_back();
  const Mesh before = mesh;
  EXPECT_EQ(TurnClosedPartsOutward(mesh), 0);
  EXPECT_EQ(mesh.triangles, before.triangles);
  EXPECT_EQ(mesh.normals, before.normals);
  Mesh nothing;
  EXPECT_EQ(TurnClosedPartsOutward(nothing), 0);
}

// Two parts that share one vertex of the mesh: the turned one gets its own.
TEST(TurnClosedPartsOutward, GivesATurnedPartItsOwnVertices) {
  Mesh mesh;
  AddTetrahedron({0, 0, 0}, false, mesh);
  AddTetrahedron({2, 2, 2}, true, mesh);  // Its corner (-1, -1, 1) and so on; join one by hand.
  const std::uint32_t shared = 0;
  mesh.positions_m[5] = mesh.positions_m[shared];
  for (std::size_t t = 4; t < 8; ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.triangles[t][corner] == 5) mesh.triangles[t][corner] = shared;
    }
  }
  EXPECT_EQ(TurnClosedPartsOutward(mesh), 4);
  ExpectAllOutward(mesh, {0, 0, 0}, 0);
  EXPECT_EQ(mesh.positions_m.size(), 9u);
  EXPECT_EQ(mesh.normals.size(), 9u);
}

}  // namespace
}  // namespace pleinair::mesh_orientation_test

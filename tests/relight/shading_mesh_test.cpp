#include "relight/transport/shading_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/textured_material.h"

namespace pleinair::shading_mesh_test {
namespace {

Mesh Square(float side_m) {
  Mesh mesh;
  mesh.positions_m = {{0, 0, 0}, {side_m, 0, 0}, {side_m, side_m, 0}, {0, side_m, 0}};
  mesh.normals.assign(4, {0.0f, 0.0f, 1.0f});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_group = {0, 0};
  mesh.triangle_material = {0, 0};
  mesh.group_names = {"square"};
  mesh.materials.resize(1);
  return mesh;
}

float LongestEdge(const Mesh& mesh) {
  float longest = 0.0f;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      longest = std::max(longest,
                         glm::distance(mesh.positions_m[t[i]], mesh.positions_m[t[(i + 1) % 3]]));
    }
  }
  return longest;
}

double Area(const Mesh& mesh) {
  double area = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    area += 0.5 * glm::length(glm::cross(mesh.positions_m[t.y] - mesh.positions_m[t.x],
                                         mesh.positions_m[t.z] - mesh.positions_m[t.x]));
  }
  return area;
}

TEST(ShadingMesh, CutsLongEdgesAndKeepsTheSurface) {
  for (const float side_m : {1e-3f, 2.0f, 1e3f}) {
    const Mesh fine = MakeShadingMesh(Square(side_m));
    EXPECT_LE(LongestEdge(fine), 0.04f * std::sqrt(2.0f) * side_m);
    EXPECT_NEAR(Area(fine), side_m * side_m, 1e-5 * side_m * side_m);
    EXPECT_EQ(fine.normals.size(), fine.positions_m.size());
    EXPECT_EQ(fine.triangle_material.size(), fine.triangles.size());
    for (const glm::vec3& normal : fine.normals) EXPECT_EQ(normal, glm::vec3(0.0f, 0.0f, 1.0f));
  }
}

// At 1e6 m floats are 0.06 m apart, as long as an edge should be: cutting ends where a middle is
// one of the ends, and not with the memory.
TEST(ShadingMesh, StopsWhereFloatsHaveNoMiddle) {
  for (const glm::vec3 offset_m : {glm::vec3(1e6f, 0, 0), glm::vec3(1e6f, 1e6f, 0)}) {
    Mesh far = Square(0.6f);
    for (glm::vec3& position_m : far.positions_m) position_m += offset_m;
    const Mesh fine = MakeShadingMesh(far);
    EXPECT_GE(fine.triangles.size(), 2u);
    EXPECT_LE(fine.triangles.size(), ShadingMeshOptions::kFewTriangles);
    // The corners move by half a step each: an area of 0.625 by 0.6 m at most.
    EXPECT_NEAR(Area(fine), 0.36, 0.05);
  }
}

// Red grows to the right, blue up: every corner keeps its place, and a piece has its own mean.
TEST(ShadingMesh, PiecesLieInTheTextureWhereTheirTriangleDid) {
  Texture::Codes codes(256, 1);
  for (int x = 0; x < 256; ++x) codes.At(x, 0) = glm::u8vec4(x, 0, 0, 255);
  const auto material = std::make_shared<TexturedMaterial>();
  material->base_colour = glm::vec3(0.9f);
  material->texture = std::make_shared<const Texture>(std::move(codes));
  material->wraps = {TextureWrap::kClamp, TextureWrap::kClamp};
  Mesh square = Square(2.0f);
  square.materials[0].by_place = material;
  for (const glm::uvec3& triangle : square.triangles) {
    TriangleColours colours;
    for (int k = 0; k < 3; ++k) {
      const glm::vec2 uv = glm::vec2(square.positions_m[triangle[k]]) / 2.0f;
      colours.texture_uv[static_cast<std::size_t>(k)] = uv;
      colours.vertex_colour[static_cast<std::size_t>(k)].b = uv.y;
    }
    square.triangle_colours.push_back(colours);
  }
  const Mesh fine = MakeShadingMesh(square);
  ASSERT_EQ(fine.triangle_colours.size(), fine.triangles.size());
  EXPECT_GT(fine.triangles.size(), 500u);
  for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
    float middle_u = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const glm::vec2 expected = glm::vec2(fine.positions_m[fine.triangles[t][k]]) / 2.0f;
      const auto corner = static_cast<std::size_t>(k);
      EXPECT_EQ(fine.triangle_colours[t].texture_uv[corner], expected);
      EXPECT_EQ(fine.triangle_colours[t].vertex_colour[corner].b, expected.y);
      middle_u += expected.x / 3.0f;
    }
    const Material& own = fine.materials[fine.triangle_material[t]];
    EXPECT_EQ(own.by_place, material);
    // sRGB of the middle, to the texel, the triangle's width of 1/50 and a step of two codes.
    EXPECT_NEAR(own.diffuse_albedo.r, 0.9f * std::pow(middle_u, 2.2f), 0.03f);
  }
}

TEST(ShadingMesh, StaysWithinItsTriangles) {
  ShadingMeshOptions options;
  options.longest_edge = 1e-4;
  const Mesh fine = MakeShadingMesh(Square(1.0f), options);
  EXPECT_LE(fine.triangles.size(), ShadingMeshOptions::kFewTriangles);
  EXPECT_GT(fine.triangles.size(), ShadingMeshOptions::kFewTriangles / 8);
}

TEST(ShadingMesh, LeavesAFineMeshAndAnEmptyOneAsTheyAre) {
  ShadingMeshOptions options;
  options.longest_edge = 1.0;
  EXPECT_EQ(MakeShadingMesh(Square(1.0f), options).positions_m, Square(1.0f).positions_m);
  EXPECT_TRUE(MakeShadingMesh(Mesh{}).triangles.empty());
}

TEST(ShadingMesh, RefusesOptionsThatMakeNoSense) {
  ShadingMeshOptions options;
  options.longest_edge = 0.0;
  EXPECT_THROW(MakeShadingMesh(Square(1.0f), options), std::invalid_argument);
  options.longest_edge = 0.1;
  options.most_growth = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(MakeShadingMesh(Square(1.0f), options), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::shading_mesh_test

// Normals of noisy meshes of small triangles, and of edges in them.

#include "relight/transport/internal/smooth_normals.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace pleinair::smooth_normals_test {
namespace {

using internal::SmoothNormals;

constexpr int kCells = 40;  // A side.
constexpr int kMiddle = kCells / 2;

// Squares of 10 cm of two triangles each, from (0, 0); `height_m` of a corner.
template <class Height>
Mesh Terrain(const Height& height_m) {
  Mesh mesh;
  for (int y = 0; y <= kCells; ++y) {
    for (int x = 0; x <= kCells; ++x) {
      mesh.positions_m.emplace_back(
          0.1f * static_cast<float>(x), 0.1f * static_cast<float>(y), height_m(x, y));
    }
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const auto corner = static_cast<std::uint32_t>(y * (kCells + 1) + x);
      const std::uint32_t above = corner + kCells + 1;
      mesh.triangles.emplace_back(corner, corner + 1, above + 1);
      mesh.triangles.emplace_back(corner, above + 1, above);
    }
  }
  return mesh;
}

double DegreesBetween(const glm::vec3& a, const glm::vec3& b) {
  return std::atan2(glm::length(glm::cross(glm::dvec3(a), glm::dvec3(b))),
                    glm::dot(glm::dvec3(a), glm::dvec3(b))) *
         180.0 / std::numbers::pi;
}

std::vector<glm::vec3> AllSmooth(const Mesh& mesh) {
  return SmoothNormals(mesh, std::vector<std::uint8_t>(mesh.triangles.size(), 1));
}

TEST(SmoothNormals, NoiseOfAPlaneFades) {
  std::mt19937 random(5);
  std::normal_distribution<float> noise_m(0.0f, 0.01f);  // A tenth of an edge.
  const Mesh mesh = Terrain([&](int, int) { return noise_m(random); });
  const std::vector<glm::vec3> normals = AllSmooth(mesh);
  double before = 0.0;
  double after = 0.0;
  double most = 0.0;
  for (std::size_t t = 0; t < normals.size(); ++t) {
    EXPECT_NEAR(glm::length(normals[t]), 1.0f, 1e-5f);
    const glm::vec3 up(0.0f, 0.0f, 1.0f);
    before += DegreesBetween(TriangleNormal(mesh, static_cast<std::uint32_t>(t)), up);
    after += DegreesBetween(normals[t], up);
    most = std::max(most, DegreesBetween(normals[t], up));
  }
  EXPECT_GT(before / static_cast<double>(normals.size()), 8.0);
  EXPECT_LT(after / static_cast<double>(normals.size()), 2.5);
  EXPECT_LT(most, 10.0);
}

// A step of a metre: its wall is one row of triangles that are ten times as tall as wide.
TEST(SmoothNormals, EdgesOfBuildingsStay) {
  const Mesh mesh = Terrain([](int x, int) { return x < kMiddle ? 0.0f : 1.0f; });
  const std::vector<glm::vec3> normals = AllSmooth(mesh);
  for (std::size_t t = 0; t < normals.size(); ++t) {
    EXPECT_LT(DegreesBetween(normals[t], TriangleNormal(mesh, static_cast<std::uint32_t>(t))), 0.1)
        << t;
  }
}

// Half a cylinder of 2 m radius, whose triangles turn by 3 deg from row to row.
TEST(SmoothNormals, CurvesStay) {
  const auto height_m = [](float x_m) { return std::sqrt(std::max(0.0f, 4.5f - x_m * x_m)); };
  const Mesh mesh =
      Terrain([&](int x, int) { return height_m(0.1f * static_cast<float>(x - kMiddle)); });
  const std::vector<glm::vec3> normals = AllSmooth(mesh);
  for (std::size_t t = 0; t < normals.size(); ++t) {
    const std::size_t column = t / 2 % kCells;
    if (column < 5 || column + 5 >= kCells) continue;  // Where it ends there is one side alone.
    EXPECT_LT(DegreesBetween(normals[t], TriangleNormal(mesh, static_cast<std::uint32_t>(t))), 3.5)
        << t;
  }
}

TEST(SmoothNormals, ASliverTakesWhatIsAroundIt) {
  Mesh mesh = Terrain([](int, int) { return 0.0f; });
  // Two corners almost in one place, one of them lifted: a triangle that stands up.
  const std::size_t moved = 20 * (kCells + 1) + 20;
  mesh.positions_m[moved] = mesh.positions_m[moved + 1] + glm::vec3(-1e-4f, 0.0f, 1e-3f);
  const std::vector<glm::vec3> normals = AllSmooth(mesh);
  int standing = 0;
  for (std::size_t t = 0; t < normals.size(); ++t) {
    const glm::vec3 own = TriangleNormal(mesh, static_cast<std::uint32_t>(t));
    if (DegreesBetween(own, {0.0f, 0.0f, 1.0f}) > 30.0) ++standing;
    EXPECT_LT(DegreesBetween(normals[t], {0.0f, 0.0f, 1.0f}), 3.0) << t;
  }
  EXPECT_GT(standing, 0);
}

TEST(SmoothNormals, CornersAreTheSameWhereTheyLie) {
  std::mt19937 random(6);
  std::normal_distribution<float> noise_m(0.0f, 0.01f);
  const Mesh mesh = Terrain([&](int, int) { return noise_m(random); });
  Mesh split = mesh;
  split.positions_m.clear();
  for (glm::uvec3& triangle : split.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      split.positions_m.push_back(mesh.positions_m[triangle[corner]]);
      triangle[corner] = static_cast<std::uint32_t>(split.positions_m.size() - 1);
    }
  }
  EXPECT_EQ(AllSmooth(split), AllSmooth(mesh));
}

TEST(SmoothNormals, LargeTrianglesKeepTheirOwn) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise_m(0.0f, 0.01f);
  Mesh mesh = Terrain([&](int, int) { return noise_m(random); });
  mesh.triangles[7] = {3, 3, 4};  // Without area.
  const std::vector<glm::vec3> normals =
      SmoothNormals(mesh, std::vector<std::uint8_t>(mesh.triangles.size(), 0));
  for (std::size_t t = 0; t < normals.size(); ++t) {
    EXPECT_EQ(normals[t], TriangleNormal(mesh, static_cast<std::uint32_t>(t)));
  }
  EXPECT_EQ(AllSmooth(mesh)[7], glm::vec3(0.0f));
  EXPECT_TRUE(SmoothNormals(Mesh(), {}).empty());
}

}  // namespace
}  // namespace pleinair::smooth_normals_test

#include "objects/internal/vertex_smoothing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/objects/placement_stage.h"

namespace pleinair::vertex_smoothing_test {
namespace {

constexpr int kSide = 12;
constexpr int kRays = 256;

// A level square of 12 x 12 vertices, 2 cm apart, that faces up.
Mesh Grid(float z_m = 0.0f) {
  Mesh mesh;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      mesh.positions_m.emplace_back(
          0.02f * static_cast<float>(x), 0.02f * static_cast<float>(y), z_m);
      mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);
      if (x == 0 || y == 0) continue;
      const auto here = static_cast<std::uint32_t>(y * kSide + x);
      mesh.triangles.emplace_back(here, here - 1, here - 1 - kSide);
      mesh.triangles.emplace_back(here, here - 1 - kSide, here - kSide);
    }
  }
  return mesh;
}

std::vector<float> Open(const Mesh& mesh) { return std::vector<float>(mesh.positions_m.size()); }

// Light that changes evenly over the place.
std::vector<glm::vec3> EvenLight(const Mesh& mesh) {
  std::vector<glm::vec3> light;
  for (const glm::vec3& at_m : mesh.positions_m) {
    light.push_back(glm::vec3(1.0f, 2.0f, 3.0f) + 5.0f * at_m.x -
                    glm::vec3(0.0f, 4.0f, 2.0f) * at_m.y);
  }
  return light;
}

double RootMeanSquare(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += glm::dot(a[i] - b[i], a[i] - b[i]) / 3.0;
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(VertexSmoothing, LightThatChangesEvenlyStays) {
  const Mesh mesh = Grid();
  const std::vector<glm::vec3> light = EvenLight(mesh);
  const std::vector<glm::vec3> smoothed = VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool is_inside = x > 1 && y > 1 && x < kSide - 2 && y < kSide - 2;
      const std::size_t i = static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x);
      // At the rim, the slope that is drawn to none: a tenth of an edge's change, 0.1.
      EXPECT_LT(glm::distance(smoothed[i], light[i]), is_inside ? 1e-5f : 0.02f) << x << ' ' << y;
    }
  }
}

TEST(VertexSmoothing, NoiseIsLessThanHalfOfWhatItWas) {
  const Mesh mesh = Grid();
  const std::vector<glm::vec3> light = EvenLight(mesh);
  std::vector<glm::vec3> noisy = light;
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0f, 0.1f);
  for (glm::vec3& rgb : noisy) rgb += glm::vec3(noise(random), noise(random), noise(random));
  const std::vector<glm::vec3> smoothed = VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(noisy);
  EXPECT_NEAR(RootMeanSquare(noisy, light), 0.1, 0.01);
  EXPECT_LT(RootMeanSquare(smoothed, light), 0.04);
}

TEST(VertexSmoothing, FacesOfOtherNormalsDoNotMix) {
  // The same places once more, facing down.
  Mesh mesh = Grid();
  const auto count = static_cast<std::uint32_t>(mesh.positions_m.size());
  const Mesh below = Grid();
  mesh.positions_m.insert(
      mesh.positions_m.end(), below.positions_m.begin(), below.positions_m.end());
  mesh.normals.resize(mesh.positions_m.size(), glm::vec3(0.0f, 0.0f, -1.0f));
  for (const glm::uvec3& corners : below.triangles) mesh.triangles.push_back(corners + count);
  std::vector<glm::vec3> light(mesh.positions_m.size(), glm::vec3(1.0f));
  std::fill(light.begin() + count, light.end(), glm::vec3(9.0f));
  const std::vector<glm::vec3> smoothed = VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light);
  EXPECT_LT(RootMeanSquare(smoothed, light), 1e-5);
}

// Where colours or textures meet.
TEST(VertexSmoothing, DoubledVerticesOfAFaceGetOneLight) {
  Mesh mesh = Grid();
  const auto count = static_cast<std::uint32_t>(mesh.positions_m.size());
  mesh.positions_m.insert(mesh.positions_m.end(), mesh.positions_m.begin(), mesh.positions_m.end());
  mesh.normals.resize(mesh.positions_m.size(), glm::vec3(0.0f, 0.0f, 1.0f));
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) mesh.triangles[t] += count;
  std::vector<glm::vec3> light = EvenLight(mesh);
  for (std::size_t v = count; v < light.size(); ++v) light[v] += 0.2f;
  const std::vector<glm::vec3> smoothed = VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light);
  for (std::size_t v = 0; v < count; ++v) {
    EXPECT_LT(glm::distance(smoothed[v], smoothed[v + count]), 1e-4f) << v;
  }
}

TEST(VertexSmoothing, ACrevicesDarkStaysWhereItIs) {
  const Mesh mesh = Grid();
  std::vector<float> hidden_share = Open(mesh);
  std::vector<glm::vec3> light(mesh.positions_m.size(), glm::vec3(1.0f));
  for (std::size_t v = 0; v < kSide; ++v) {
    hidden_share[v] = 0.4f;
    light[v] = glm::vec3(0.2f);
  }
  hidden_share[5 * kSide + 5] = 1.0f;  // Within an object.
  light[5 * kSide + 5] = glm::vec3(0.0f);
  const std::vector<glm::vec3> smoothed =
      VertexSmoothing(mesh, hidden_share, kRays).Smoothed(light);
  EXPECT_LT(RootMeanSquare(smoothed, light), 1e-4);
  EXPECT_EQ(smoothed[5 * kSide + 5], glm::vec3(0.0f));
}

TEST(VertexSmoothing, OnASphereLightByTheNormalStays) {
  const Mesh mesh = placement_stage::SphereMesh(0.3f, 24, 48);
  std::vector<glm::vec3> light;
  for (const glm::vec3& normal : mesh.normals) light.emplace_back(1.0f + 0.5f * normal.x);
  const std::vector<glm::vec3> smoothed = VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light);
  EXPECT_LT(RootMeanSquare(smoothed, light), 0.004);
}

TEST(VertexSmoothingHardCases, WhatHasNoShapeKeepsItsLight) {
  Mesh mesh = Grid();
  mesh.positions_m.assign(mesh.positions_m.size(), glm::vec3(1.0f));  // All in one place.
  const std::vector<glm::vec3> light = EvenLight(Grid());
  EXPECT_EQ(VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light), light);
  mesh = Grid();
  mesh.normals.assign(mesh.normals.size(), glm::vec3(0.0f));
  EXPECT_EQ(VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light), light);
  mesh = Grid();
  mesh.triangles.clear();
  EXPECT_EQ(VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light), light);
  EXPECT_TRUE(VertexSmoothing(Mesh{}, {}, kRays).Smoothed({}).empty());
  EXPECT_EQ(VertexSmoothing().Smoothed(light), light) << "of no shape";
}

TEST(VertexSmoothingHardCases, AFanOfManyTrianglesIsSmoothed) {
  Mesh mesh;
  mesh.positions_m.emplace_back(0.0f);
  constexpr std::uint32_t kRim = 20'000;
  for (std::uint32_t i = 0; i < kRim; ++i) {
    const float turn = 6.2831853f * static_cast<float>(i) / kRim;
    mesh.positions_m.emplace_back(std::cos(turn), std::sin(turn), 0.0f);
    mesh.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % kRim);
  }
  mesh.normals.assign(mesh.positions_m.size(), glm::vec3(0.0f, 0.0f, 1.0f));
  const std::vector<glm::vec3> even(mesh.positions_m.size(), glm::vec3(2.0f));
  const auto smoothed = VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(even);
  EXPECT_LT(RootMeanSquare(smoothed, even), 1e-4);
}

TEST(VertexSmoothingHardCases, LightIsNeverNegative) {
  const Mesh mesh = Grid();
  std::vector<glm::vec3> light(mesh.positions_m.size(), glm::vec3(0.0f));
  for (std::size_t v = 0; v < light.size(); v += 7) light[v] = glm::vec3(1e6f);
  for (const glm::vec3& rgb : VertexSmoothing(mesh, Open(mesh), kRays).Smoothed(light)) {
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_GE(rgb[channel], 0.0f);
      EXPECT_TRUE(std::isfinite(rgb[channel]));
    }
  }
}

}  // namespace
}  // namespace pleinair::vertex_smoothing_test

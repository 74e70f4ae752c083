#include "pipeline/object_gather.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair {
namespace {

PatchScene SceneOf(Mesh mesh) {
  PatchScene scene;
  scene.mesh = std::move(mesh);
  scene.caster = RayCaster(scene.mesh);
  return scene;
}

// Level, facing up, around (0, 0, height).
Mesh Square(float half_side_m, float height_m) {
  Mesh mesh;
  mesh.positions_m = {{-half_side_m, -half_side_m, height_m},
                      {half_side_m, -half_side_m, height_m},
                      {half_side_m, half_side_m, height_m},
                      {-half_side_m, half_side_m, height_m}};
  mesh.normals.assign(4, {0.0f, 0.0f, 1.0f});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

// One vertex a metre above the middle of the ground, looking to `normal`.
Mesh PointAbove(const glm::vec3& normal) {
  Mesh mesh;
  mesh.positions_m = {{0.0f, 0.0f, 1.0f}, {1e-3f, 0.0f, 1.0f}, {0.0f, 1e-3f, 1.0f}};
  mesh.normals.assign(3, normal);
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

constexpr GatherOptions kManyRays{.rays_per_receiver = 4096};
const std::vector<glm::vec3> kDarkPair(2, glm::vec3(0.0f));

// 1e-5: nothing but rounding, since each ray that leaves upwards reaches the sky.
TEST(ObjectGather, AnOpenLevelVertexGetsTheWholeSky) {
  const ObjectGather gather(
      SceneOf(PointAbove({0.0f, 0.0f, 1.0f})), SceneOf(Square(50.0f, 0.0f)), kManyRays);
  ASSERT_EQ(gather.VertexCount(), 3u);
  const auto sky = MakeUniformSkyShape();
  const std::vector<glm::vec3> dark(4, glm::vec3(0.0f));
  for (const glm::vec3& irradiance : gather.Irradiance(sky.get(), kDarkPair, dark)) {
    EXPECT_NEAR(irradiance.y, 1.0, 1e-5);
  }
  EXPECT_EQ(gather.Irradiance(nullptr, kDarkPair, dark)[0], glm::vec3(0.0f));
}

// A wall's vertex sees half sky, half ground. 4096 stratified rays: 1 / sqrt(4096) at the worst.
TEST(ObjectGather, AVerticalVertexGetsHalfOfSkyAndGround) {
  const ObjectGather gather(
      SceneOf(PointAbove({1.0f, 0.0f, 0.0f})), SceneOf(Square(5000.0f, 0.0f)), kManyRays);
  const auto sky = MakeUniformSkyShape();
  const std::vector<glm::vec3> ground(4, glm::vec3(0.3f, 0.2f, 0.1f));
  const glm::vec3 irradiance = gather.Irradiance(sky.get(), kDarkPair, ground)[0];
  EXPECT_NEAR(irradiance.x, 0.5 + 0.5 * 0.3, 0.016);
  EXPECT_NEAR(irradiance.z, 0.5 + 0.5 * 0.1, 0.016);
}

// Under a disc-like square of an object: the parallel square's form factor from its middle,
// 2 / pi * 2 (a / sqrt(1 + a^2)) atan(a / sqrt(1 + a^2)) with a = half side / distance.
TEST(ObjectGather, WhatObjectsHideOfTheSkyIsReplacedByTheirOwnRadiosity) {
  Mesh objects = PointAbove({0.0f, 0.0f, 1.0f});
  const Mesh lid = Square(2.0f, 3.0f);
  for (const glm::uvec3& triangle : lid.triangles) objects.triangles.push_back(triangle + 3u);
  objects.positions_m.insert(
      objects.positions_m.end(), lid.positions_m.begin(), lid.positions_m.end());
  objects.normals.insert(objects.normals.end(), lid.normals.begin(), lid.normals.end());
  const ObjectGather gather(SceneOf(objects), SceneOf(Square(50.0f, 0.0f)), kManyRays);
  const double b = 1.0 / std::sqrt(2.0);
  const double factor = 4.0 / std::numbers::pi * b * std::atan(b);
  const auto sky = MakeUniformSkyShape();
  const std::vector<glm::vec3> glow(6, glm::vec3(0.25f));
  const std::vector<glm::vec3> dark(4, glm::vec3(0.0f));
  EXPECT_NEAR(gather.Irradiance(sky.get(), glow, dark)[0].y, (1.0 - factor) + 0.25 * factor, 0.016);
}

// A furnace: light of one strength from everywhere is that strength at every vertex.
TEST(ObjectGather, IsOneInAFurnace) {
  const ObjectGather gather(
      SceneOf(PointAbove({0.6f, 0.0f, -0.8f})), SceneOf(Square(5000.0f, 0.0f)), kManyRays);
  const auto sky = MakeUniformSkyShape();
  const std::vector<glm::vec3> white(4, glm::vec3(1.0f));
  const std::vector<glm::vec3> white_object(2, glm::vec3(1.0f));
  // Rays that pass the ground's end below the horizon are dark: 1 / 5000 of them at most.
  EXPECT_NEAR(gather.Irradiance(sky.get(), white_object, white)[0].y, 1.0, 1e-3);
}

TEST(ObjectGather, RefusesRadiositiesOfAnotherScene) {
  const ObjectGather gather(
      SceneOf(PointAbove({0.0f, 0.0f, 1.0f})), SceneOf(Square(50.0f, 0.0f)), kManyRays);
  EXPECT_THROW(gather.Irradiance(nullptr, kDarkPair, kDarkPair), std::invalid_argument);
  EXPECT_THROW(gather.Irradiance(nullptr, {}, std::vector<glm::vec3>(4)), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair

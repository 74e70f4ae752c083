#include "objects/object_gather.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "objects/near_sunlight.h"

namespace pleinair::object_gather_test {
namespace {

PatchScene UncutScene(Mesh mesh) {
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
      UncutScene(PointAbove({0.0f, 0.0f, 1.0f})), UncutScene(Square(50.0f, 0.0f)), kManyRays);
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
      UncutScene(PointAbove({1.0f, 0.0f, 0.0f})), UncutScene(Square(5000.0f, 0.0f)), kManyRays);
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
  const ObjectGather gather(UncutScene(objects), UncutScene(Square(50.0f, 0.0f)), kManyRays);
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
      UncutScene(PointAbove({0.6f, 0.0f, -0.8f})), UncutScene(Square(5000.0f, 0.0f)), kManyRays);
  const auto sky = MakeUniformSkyShape();
  const std::vector<glm::vec3> white(4, glm::vec3(1.0f));
  const std::vector<glm::vec3> white_object(2, glm::vec3(1.0f));
  // Rays that pass the ground's end below the horizon are dark: 1 / 5000 of them at most.
  EXPECT_NEAR(gather.Irradiance(sky.get(), white_object, white)[0].y, 1.0, 1e-3);
}

// 50 triangles apart are 150 vertices: three parts.
TEST(ObjectGather, APartThatIsNamedTwiceIsCastOnce) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < 50; ++i) {
    const Mesh one = PointAbove({0.0f, 0.0f, 1.0f});
    for (const glm::vec3& at : one.positions_m)
      mesh.positions_m.push_back(at + glm::vec3(static_cast<float>(i)));
    mesh.normals.insert(mesh.normals.end(), one.normals.begin(), one.normals.end());
    mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  const PatchScene objects = UncutScene(mesh);
  const PatchScene real = UncutScene(Square(50.0f, 0.0f));
  ObjectGather gather = ObjectGather::InParts(objects, real, GatherOptions{.rays_per_receiver = 8});
  ASSERT_EQ(gather.PartCount(), 3u);
  gather.Cast(objects, real, std::vector<std::size_t>{0, 1, 0});
  EXPECT_FALSE(gather.IsComplete());
  EXPECT_FALSE(gather.HasCast(2));
  gather.Cast(objects, real, std::vector<std::size_t>{2, 2});
  EXPECT_TRUE(gather.IsComplete());
}

TEST(ObjectGather, RefusesRadiositiesOfAnotherScene) {
  const ObjectGather gather(
      UncutScene(PointAbove({0.0f, 0.0f, 1.0f})), UncutScene(Square(50.0f, 0.0f)), kManyRays);
  EXPECT_THROW(gather.Irradiance(nullptr, kDarkPair, kDarkPair), std::invalid_argument);
  EXPECT_THROW(gather.Irradiance(nullptr, {}, std::vector<glm::vec3>(4)), std::invalid_argument);
}

// A box with faces of its own vertices, outward.
void AddBox(const glm::vec3& lower, const glm::vec3& upper, Mesh& mesh) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 normal(0.0f);
      normal[axis] = side;
      const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
      for (int corner = 0; corner < 4; ++corner) {
        // Around the normal, counter-clockwise.
        const bool u = corner == 1 || corner == 2;
        const bool v = corner >= 2;
        glm::vec3 position_m;
        position_m[axis] = side > 0.0f ? upper[axis] : lower[axis];
        const int across = (axis + (side > 0.0f ? 1 : 2)) % 3;
        const int up = (axis + (side > 0.0f ? 2 : 1)) % 3;
        position_m[across] = u ? upper[across] : lower[across];
        position_m[up] = v ? upper[up] : lower[up];
        mesh.positions_m.push_back(position_m);
        mesh.normals.push_back(normal);
      }
      mesh.triangles.push_back(glm::uvec3(0, 1, 2) + first);
      mesh.triangles.push_back(glm::uvec3(0, 2, 3) + first);
    }
  }
}

// Two boxes put together in a furnace, dark inside: what shows outside is white to the joint. Of
// the upper box the corners below, which lie in the lower one's top, and of that top its corners.
// 0.03: 64 rays a point.
TEST(ObjectGather, JointsOfPartsAreNotDark) {
  Mesh mesh;
  AddBox({-0.5f, -0.5f, 0.1f}, {0.5f, 0.5f, 1.0f}, mesh);
  AddBox({-0.3f, -0.3f, 1.0f}, {0.3f, 0.3f, 2.0f}, mesh);
  const PatchScene objects = UncutScene(mesh);
  const ObjectGather gather(objects, UncutScene(Square(5000.0f, 0.0f)), {.rays_per_receiver = 256});
  const auto sky = MakeUniformSkyShape();
  std::vector<glm::vec3> white_outside(objects.FaceCount(), glm::vec3(0.0f));
  for (std::size_t face = 0; face < white_outside.size(); face += 2) {
    white_outside[face] = glm::vec3(1.0f);
  }
  const std::vector<glm::vec3> ground(4, glm::vec3(1.0f));
  const std::vector<glm::vec3> irradiance = gather.Irradiance(sky.get(), white_outside, ground);
  int at_joint = 0;
  for (std::size_t v = 0; v < irradiance.size(); ++v) {
    const bool upper_boxs_side = v >= 24 && std::abs(mesh.normals[v].z) < 0.5f;
    const bool lower_boxs_top = v < 24 && mesh.normals[v].z > 0.5f;
    if (!upper_boxs_side && !lower_boxs_top) continue;
    at_joint += mesh.positions_m[v].z == 1.0f ? 1 : 0;
    EXPECT_NEAR(irradiance[v].y, 1.0, 0.03) << "vertex " << v;
  }
  EXPECT_EQ(at_joint, 12);
}

// A lid a metre over sunlit ground sees its own shadow there: the change of NearSunlight.
TEST(ObjectGather, TakesThePlacesSunForThePatchs) {
  const PatchScene objects = UncutScene(PointAbove({0.0f, 0.0f, -1.0f}));
  PatchScene ground = UncutScene(Square(50.0f, 0.0f));
  ground.face_albedo_rgb.assign(4, glm::vec3(0.5f));
  const ObjectGather gather(objects, ground, kManyRays);
  const DirectionalLight sun{{0.0, 0.0, 1.0}, {}, 0.0};
  const std::vector<glm::vec3> lit(4, glm::vec3(1.0f));
  const NearSunlight near(ground, objects, ObjectGather::PointsAround(objects.mesh));
  for (const glm::vec3& change : gather.AtVertices(near.Change(ground, objects, sun, lit))) {
    EXPECT_NEAR(change.y, 0.0, 0.01) << "it hides next to nothing";
  }
}

}  // namespace
}  // namespace pleinair::object_gather_test

// Light between objects, against form factors and furnaces.
#include "objects/object_interreflection.h"

#include <cmath>
#include <optional>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/relight/probe_test_scenes.h"

namespace pleinair::object_interreflection_test {
namespace {

// One in 128 rays, the number that a vertex casts.
constexpr double kOneRay = 1.0 / 128.0;

VirtualObject ObjectOf(Mesh mesh, const glm::vec3& albedo, const glm::vec3& mirrored = {}) {
  mesh.materials = {{.name = "all", .diffuse_albedo = albedo, .specular_reflectance = mirrored}};
  mesh.group_names = {"object"};
  return {std::move(mesh)};
}

std::vector<std::vector<glm::vec3>> OneEverywhere(const std::vector<VirtualObject>& objects) {
  std::vector<std::vector<glm::vec3>> irradiance;
  irradiance.reserve(objects.size());
  for (const VirtualObject& object : objects) {
    irradiance.emplace_back(object.mesh.positions_m.size(), glm::vec3(1.0f));
  }
  return irradiance;
}

DirectionalLight NoSun() { return {}; }

// A tile of 2 cm that looks up from `middle`.
Mesh Tile(const glm::vec3& middle) {
  Mesh mesh;
  const float s = 0.01f;
  AddQuad(mesh,
          middle + glm::vec3(-s, -s, 0.0f),
          middle + glm::vec3(s, -s, 0.0f),
          middle + glm::vec3(s, s, 0.0f),
          middle + glm::vec3(-s, s, 0.0f));
  return mesh;
}

TEST(ObjectInterreflection, WhiteObjectsInAWhiteFurnaceCannotBeSeen) {
  Mesh trough;
  AddBox(trough, {-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, true, false);
  Mesh box;
  AddBox(box, {-0.3f, -0.3f, 0.2f}, {0.3f, 0.3f, 0.6f});
  const std::vector<VirtualObject> objects{ObjectOf(trough, glm::vec3(1.0f)),
                                           ObjectOf(box, glm::vec3(1.0f))};
  ObjectInterreflection light(objects);
  std::vector<std::vector<glm::vec3>> irradiance = OneEverywhere(objects);
  light.Apply(NoSun(), irradiance);
  for (const std::vector<glm::vec3>& object : irradiance) {
    // Float's rounding over 128 shares.
    for (const glm::vec3& value : object) EXPECT_NEAR(value.y, 1.0f, 1e-5f);
  }
  for (const glm::vec3& radiosity : light.FaceRadiosity(NoSun(), irradiance)) {
    EXPECT_NEAR(radiosity.y, 1.0f, 1e-5f);
  }
}

// All that the tile sees are the room's faces: one reflection of what reaches those.
TEST(ObjectInterreflection, InAClosedRoomOnlyTheReflectionIsLeft) {
  Mesh room;
  AddBox(room, {-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, true);
  const glm::vec3 albedo(0.7f, 0.4f, 0.1f);
  const std::vector<VirtualObject> objects{ObjectOf(room, albedo),
                                           ObjectOf(Tile({0.2f, 0.1f, 0.3f}), glm::vec3(0.5f))};
  ObjectInterreflection light(objects);
  std::vector<std::vector<glm::vec3>> irradiance = OneEverywhere(objects);
  light.Apply(NoSun(), irradiance);
  for (const glm::vec3& value : irradiance[1]) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], albedo[c], 1e-5f);
  }
}

// A strip of wall of height H, far to both sides, fills 1/2 (1 - d / sqrt(d^2 + H^2)) of the
// hemisphere of a level point at distance d from its foot.
TEST(ObjectInterreflection, ATileBeforeAWallSeesItsFormFactor) {
  Mesh wall;
  AddQuad(wall,
          {0.0f, -500.0f, 0.0f},
          {0.0f, 500.0f, 0.0f},
          {0.0f, 500.0f, 2.0f},
          {0.0f, -500.0f, 2.0f});
  const float albedo = 0.6f;
  const std::vector<VirtualObject> objects{ObjectOf(wall, glm::vec3(albedo)),
                                           ObjectOf(Tile({1.0f, 0.0f, 0.0f}), glm::vec3(0.5f))};
  ObjectInterreflection light(objects);
  const double share = 0.5 * (1.0 - 1.0 / std::sqrt(5.0));

  std::vector<std::vector<glm::vec3>> irradiance = OneEverywhere(objects);
  light.Apply(NoSun(), irradiance);
  for (const glm::vec3& value : irradiance[1]) {
    // Two rays at the wall's rim, and the tile's half side of 1 cm: 0.9 % of d.
    EXPECT_NEAR(value.x, 1.0 - (1.0 - albedo) * share, 2.0 * kOneRay);
  }

  // In the sun alone, 45 deg before and above the wall.
  DirectionalLight sun;
  sun.direction_enu = glm::normalize(glm::dvec3(1.0, 0.0, 1.0));
  sun.irradiance_rgb = {2.0, 4.0, 8.0};
  light.UpdateSun(RayCaster(Mesh{}), sun.direction_enu);
  for (std::vector<glm::vec3>& object : irradiance) {
    object.assign(object.size(), glm::vec3(0.0f));
  }
  light.Apply(sun, irradiance);
  for (const glm::vec3& value : irradiance[1]) {
    const double expected = albedo * std::sqrt(0.5) * share;
    EXPECT_NEAR(value.x, 2.0 * expected, 2.0 * 2.0 * kOneRay);
    EXPECT_NEAR(value.z, 4.0f * value.x, 1e-5f);
  }

  // A real roof over all of it.
  Mesh roof;
  AddGround(roof, 1000.0f, 10.0f);
  light.UpdateSun(RayCaster(roof), sun.direction_enu);
  for (std::vector<glm::vec3>& object : irradiance) {
    object.assign(object.size(), glm::vec3(0.0f));
  }
  light.Apply(sun, irradiance);
  for (const glm::vec3& value : irradiance[1]) EXPECT_EQ(value, glm::vec3(0.0f));
}

// A mirror's image of the sky is as bright as a white surface in the mean; its image of the sun is
// a caustic, which nobody draws.
TEST(ObjectInterreflection, OnlyTheDiffusePartReflectsTheSun) {
  const std::vector<VirtualObject> objects{
      ObjectOf(Tile({0.0f, 0.0f, 0.0f}), glm::vec3(0.2f), glm::vec3(0.5f))};
  ObjectInterreflection light(objects);
  DirectionalLight sun;
  sun.irradiance_rgb = glm::dvec3(10.0);  // From the zenith.
  light.UpdateSun(RayCaster(Mesh{}), sun.direction_enu);
  std::vector<std::vector<glm::vec3>> irradiance = OneEverywhere(objects);
  light.Apply(sun, irradiance);
  const std::vector<glm::vec3> radiosity = light.FaceRadiosity(sun, irradiance);
  EXPECT_NEAR(radiosity[0].x, 0.7f + 2.0f, 1e-5f) << "the side to the sun";
  EXPECT_NEAR(radiosity[1].x, 0.7f, 1e-5f) << "the other side";
}

// Light that is past the objects already is hidden no second time, and reflected once.
TEST(ObjectInterreflection, DirectLightIsAddedInFullAndReflected) {
  Mesh room;
  AddBox(room, {-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, true);
  const std::vector<VirtualObject> objects{ObjectOf(room, glm::vec3(0.4f)),
                                           ObjectOf(Tile({0.2f, 0.1f, 0.3f}), glm::vec3(0.5f))};
  ObjectInterreflection light(objects);
  const std::size_t vertices = light.Objects().mesh.positions_m.size();
  std::vector<std::vector<glm::vec3>> irradiance;
  irradiance.reserve(objects.size());
  for (const VirtualObject& object : objects) {
    irradiance.emplace_back(object.mesh.positions_m.size(), glm::vec3(0.0f));
  }
  light.Apply(NoSun(), irradiance, std::vector<glm::vec3>(vertices, glm::vec3(3.0f)));
  // All that the tile sees are the room's faces.
  for (const glm::vec3& value : irradiance[1]) EXPECT_NEAR(value.x, 3.0f + 0.4f * 3.0f, 1e-5f);
  EXPECT_THROW(light.Apply(NoSun(), irradiance, std::vector<glm::vec3>(vertices + 1)),
               std::invalid_argument);
}

TEST(ObjectInterreflection, KeepsItsObjectsApart) {
  const std::vector<VirtualObject> objects{ObjectOf(Tile({0.0f, 0.0f, 0.0f}), glm::vec3(0.1f)),
                                           ObjectOf(Mesh{}, glm::vec3(0.5f)),
                                           ObjectOf(Tile({1.0f, 0.0f, 0.0f}), glm::vec3(0.9f))};
  ObjectInterreflection light(objects);
  const Mesh& joined = light.Objects().mesh;
  EXPECT_EQ(joined.group_names.size(), 3u);
  EXPECT_EQ(joined.triangle_group, (std::vector<std::uint32_t>{0, 0, 2, 2}));
  std::vector<std::vector<glm::vec3>> irradiance = OneEverywhere(objects);
  light.Apply(NoSun(), irradiance);
  const std::vector<glm::vec3> radiosity = light.FaceRadiosity(NoSun(), irradiance);
  EXPECT_NEAR(radiosity.front().x, 0.1f, 1e-6f);
  EXPECT_NEAR(radiosity.back().x, 0.9f, 1e-6f);
}

// A box hides nothing from itself, a room all from a tile within; between them a seat with its
// back. By a few vertices or by all, and at repeated calls.
TEST(ObjectInterreflection, ReportsHowMuchObjectsHideFromThemselves) {
  Mesh box;
  AddBox(box, {-0.3f, -0.3f, 0.0f}, {0.3f, 0.3f, 0.6f});
  ObjectInterreflection of_box({ObjectOf(box, glm::vec3(0.5f))});
  EXPECT_EQ(of_box.LargestHiddenUpTo(0.02f), 0.0f);
  EXPECT_TRUE(of_box.HasCastRays());

  Mesh seat = box;
  AddBox(seat, {-0.3f, 0.2f, 0.6f}, {0.3f, 0.3f, 1.0f});
  ObjectInterreflection of_seat({ObjectOf(seat, glm::vec3(0.5f))});
  EXPECT_FALSE(of_seat.LargestHiddenUpTo(0.02f));
  EXPECT_FALSE(of_seat.LargestHiddenUpTo(0.02f)) << "remembered";
  EXPECT_FALSE(of_seat.HasCastRays()) << "a few vertices suffice";
  const std::optional<float> largest = of_seat.LargestHiddenUpTo(1.0f);
  ASSERT_TRUE(largest);
  EXPECT_GT(*largest, 0.02f);
  EXPECT_LT(*largest, 0.6f);

  Mesh room;
  AddBox(room, {-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, true);
  ObjectInterreflection within_room(
      {ObjectOf(room, glm::vec3(0.5f)), ObjectOf(Tile({0.2f, 0.1f, 0.3f}), glm::vec3(0.5f))});
  within_room.CastRays();
  EXPECT_FALSE(within_room.LargestHiddenUpTo(0.5f));
  EXPECT_EQ(within_room.LargestHiddenUpTo(1.0f), 1.0f);
}

TEST(ObjectInterreflection, NoObjectsAreNoError) {
  ObjectInterreflection light({});
  light.UpdateSun(RayCaster(Mesh{}), {0.0, 0.0, 1.0});
  std::vector<std::vector<glm::vec3>> none;
  light.Apply(NoSun(), none);
  EXPECT_TRUE(light.FaceRadiosity(NoSun(), none).empty());
}

}  // namespace
}  // namespace pleinair::object_interreflection_test

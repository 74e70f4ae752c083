#include "objects/object_reach.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/relight/probe_test_scenes.h"

namespace pleinair::object_reach_test {
namespace {

PatchScene BoxAt(const glm::vec3& centre_m, float half_side_m) {
  PatchScene scene;
  AddBox(scene.mesh, centre_m - half_side_m, centre_m + half_side_m);
  scene.mesh.group_names = {"box"};
  scene.mesh.triangle_group.assign(scene.mesh.triangles.size(), 0);
  scene.caster = RayCaster(scene.mesh);
  return scene;
}

// At the origin, looking along +y; 90 degrees across.
Camera LevelCamera() {
  Camera camera;
  camera.intrinsics = {100, 100, 50.0, 50.0, 49.5, 49.5, {}};
  camera.camera_from_world = glm::dmat4(glm::dvec4(1.0, 0.0, 0.0, 0.0),
                                        glm::dvec4(0.0, 0.0, 1.0, 0.0),
                                        glm::dvec4(0.0, -1.0, 0.0, 0.0),
                                        glm::dvec4(0.0, 0.0, 0.0, 1.0));
  return camera;
}

TEST(MayBeInView, DistinguishesWhatIsInFrontOfTheCamera) {
  const Camera camera = LevelCamera();
  EXPECT_TRUE(MayBeInView(BoxAt({0.0f, 5.0f, 0.0f}, 0.5f), camera));
  EXPECT_FALSE(MayBeInView(BoxAt({0.0f, -5.0f, 0.0f}, 0.5f), camera));
  EXPECT_FALSE(MayBeInView(BoxAt({12.0f, 5.0f, 0.0f}, 0.5f), camera));
  EXPECT_TRUE(MayBeInView(BoxAt({5.2f, 5.0f, 0.0f}, 0.5f), camera)) << "half of it";
  EXPECT_TRUE(MayBeInView(BoxAt({0.0f, 0.0f, 0.0f}, 0.5f), camera)) << "around the camera";
  EXPECT_TRUE(MayBeInView(BoxAt({2.0f, 0.0f, 0.0f}, 1.9f), camera)) << "beside and behind it";
}

// A wall that fills the picture at 10 m, and a box before it.
SurfaceView WallView() {
  SurfaceView view;
  view.camera = LevelCamera();
  view.region = Image<std::int32_t>(100, 100, 0);
  view.position_world_m = RgbImage(100, 100);
  view.normal_world = RgbImage(100, 100, glm::vec3(0.0f, -1.0f, 0.0f));
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 100; ++x) {
      view.position_world_m.At(x, y) = {
          (static_cast<float>(x) - 49.5f) / 5.0f, 10.0f, (49.5f - static_cast<float>(y)) / 5.0f};
    }
  }
  return view;
}

TEST(ReachOfInfluence, GrowsAsTheObjectComesNear) {
  const SurfaceView view = WallView();
  // Right at the wall.
  EXPECT_EQ(ReachOfInfluence(BoxAt({0.0f, 9.5f, 0.0f}, 0.5f), view).largest_share, 1.0f);
  // A sphere of radius r at distance d fills (r / d)^2 of the view before it; pixels stand 0.1 m
  // off that place.
  const InfluenceReach reach = ReachOfInfluence(BoxAt({0.0f, 6.0f, 0.0f}, 0.2f), view);
  const double share = 0.04 * 3.0 / 16.0;
  EXPECT_GE(reach.largest_share, 0.99 * share);
  EXPECT_LE(reach.largest_share, 4.01 * share);
  EXPECT_FALSE(reach.pixels.empty());
  EXPECT_LT(reach.pixels.size(), view.region.pixels.size());
  const InfluenceReach none = ReachOfInfluence(BoxAt({0.0f, 1.0f, 0.0f}, 0.05f), view);
  EXPECT_EQ(none.largest_share, 0.0f);
  EXPECT_TRUE(none.pixels.empty());
}

TEST(AnySeesSun, IsFalseForAnObjectInTheSceneShadow) {
  const DirectionalLight sun{glm::normalize(glm::dvec3(1.0, 0.0, 1.0))};
  Mesh scene;
  AddGround(scene, 20.0f);
  AddBox(scene, {2.0f, -5.0f, 0.0f}, {3.0f, 5.0f, 6.0f});
  const RayCaster real(scene);
  EXPECT_FALSE(AnySeesSun(BoxAt({0.0f, 0.0f, 0.5f}, 0.5f), real, sun));
  EXPECT_TRUE(AnySeesSun(BoxAt({-8.0f, 0.0f, 0.5f}, 0.5f), real, sun));
  // The shadow's edge goes through it: 4 m before the wall it is 2 m high.
  EXPECT_TRUE(AnySeesSun(BoxAt({-2.0f, 0.0f, 2.0f}, 0.5f), real, sun));
  EXPECT_FALSE(AnySeesSun(
      BoxAt({-8.0f, 0.0f, 0.5f}, 0.5f), real, {glm::normalize(glm::dvec3(0.0, 1.0, -0.5))}));
}

}  // namespace
}  // namespace pleinair::object_reach_test

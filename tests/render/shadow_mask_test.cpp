// Shadow volumes against ray casting. The bar is the project's: at most 0.01 % of pixels differ
// farther than one pixel from an edge.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "ray_cast_reference.h"
#include "render/gl_context.h"
#include "scene/mesh_io.h"
#include "shadow_mask.h"
#include "test_scenes.h"

namespace pleinair::test::shadow_mask_test {
namespace {

constexpr double kMaxDifferentShare = 1e-4;

class ShadowMaskOfScene : public testing::TestWithParam<GlApi> {
 protected:
  HeadlessContext context_{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(BothApis,
                         ShadowMaskOfScene,
                         testing::Values(GlApi::kDesktop45, GlApi::kEs31),
                         [](const auto& api) {
                           return api.param == GlApi::kDesktop45 ? "Desktop" : "Es";
                         });

void ExpectLikeRayCasting(const Mesh& phantom,
                          const Mesh& object,
                          const Camera& camera,
                          const glm::dvec3& to_sun,
                          const std::string& what) {
  ShadowMask mask;
  mask.SetPhantom(phantom);
  mask.SetObjects({{object}});
  const MaskComparison comparison = CompareShadowMasks(mask, Join(phantom, object), camera, to_sun);
  EXPECT_GT(comparison.shadowed, 20u) << what;  // The case covers what it tests.
  EXPECT_GT(comparison.lit, 20u) << what;
  EXPECT_LE(comparison.DifferentShare(), kMaxDifferentShare)
      << what << ": " << comparison.different_off_edges << " pixels";
}

TEST_P(ShadowMaskOfScene, OfABoxOnTheGroundIsAsRayCastingSays) {
  ExpectLikeRayCasting(Ground(20.0f),
                       Box({-1.0f, -1.0f, 0.0f}, {1.0f, 1.0f, 2.0f}),
                       LookAt({4.0, -6.0, 3.0}, {0.0, 0.0, 0.5}, 320, 240, 260.0),
                       DirectionOf(240.0, 35.0),
                       "box");
}

TEST_P(ShadowMaskOfScene, OfASphereInTheShadowOfAWallIsOneShadow) {
  const Mesh scene = Join(Ground(20.0f), Box({-4.0f, 2.0f, 0.0f}, {4.0f, 2.2f, 3.0f}));
  for (const double elevation : {10.0, 25.0, 60.0}) {
    ExpectLikeRayCasting(scene,
                         Sphere({0.5f, 0.0f, 0.8f}, 0.8f, 24),
                         LookAt({5.0, -6.0, 2.5}, {0.0, 1.0, 0.5}, 320, 240, 260.0),
                         DirectionOf(20.0, elevation),
                         "elevation " + std::to_string(elevation));
  }
}

// A real courtyard's mesh and its statue, from the recording's own camera, over a day.
TEST_P(ShadowMaskOfScene, OfTheCourtyardsStatueIsAsRayCastingSays) {
  const auto scene_file = SharedFile("sequences/courtyard-clouds/scene.obj");
  const auto object_file = SharedFile("sequences/courtyard-clouds/object.obj");
  if (!scene_file || !object_file) GTEST_SKIP() << "the recorded sequences are not here";
  const Mesh scene = LoadMesh(*scene_file).mesh;
  glm::dmat4 world_from_object(1.0);
  world_from_object[0] = {0.9563047289848328, 0.29237186908721924, 0.0, 0.0};
  world_from_object[1] = {-0.29237186908721924, 0.9563047289848328, 0.0, 0.0};
  world_from_object[3] = {-1.916210651397705, -1.6906025409698486, 0.0, 1.0};
  const Mesh object = TransformMesh(world_from_object, LoadMesh(*object_file).mesh);
  const Camera camera = LookAt({-8.34, -5.51, 1.7}, {-1.9, -1.7, 1.0}, 480, 360, 375.0);
  for (const double azimuth : {110.0, 180.0, 255.0}) {
    ExpectLikeRayCasting(
        scene, object, camera, DirectionOf(azimuth, 42.0), "azimuth " + std::to_string(azimuth));
  }
}

class ClosedMesh : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(OfTheCollection,
                         ClosedMesh,
                         testing::Values("spot.obj",
                                         "Duck.glb",
                                         "BoxTextured.glb",
                                         "negative_indices.obj",
                                         "polygonfaces.obj",
                                         "joined_tetrahedra.obj"));

// Scaled to 2 m and put on the ground.
Mesh LoadOnGround(const std::filesystem::path& file) {
  const Mesh mesh = LoadMesh(file).mesh;
  const BoundingBox box = BoundingBoxOf(mesh);
  const glm::dvec3 size(box.upper_m - box.lower_m);
  const double scale = 2.0 / std::max({size.x, size.y, size.z});
  const glm::dvec3 foot(
      0.5 * (box.lower_m.x + box.upper_m.x), 0.5 * (box.lower_m.y + box.upper_m.y), box.lower_m.z);
  glm::dmat4 world_from_mesh(1.0);
  for (int i = 0; i < 3; ++i) world_from_mesh[i][i] = scale;
  world_from_mesh[3] = glm::dvec4(-scale * foot, 1.0);
  return TransformMesh(world_from_mesh, mesh);
}

TEST_P(ClosedMesh, CastsTheShadowThatRayCastingSays) {
  const auto file = SharedFile(std::filesystem::path("data/meshes") / GetParam());
  if (!file) GTEST_SKIP() << "the collection of meshes is not here";
  const HeadlessContext context;
  ExpectLikeRayCasting(Ground(20.0f),
                       LoadOnGround(*file),
                       LookAt({3.0, -3.5, 2.2}, {0.0, 0.0, 0.6}, 480, 360, 420.0),
                       DirectionOf(215.0, 38.0),
                       GetParam());
}

}  // namespace
}  // namespace pleinair::test::shadow_mask_test

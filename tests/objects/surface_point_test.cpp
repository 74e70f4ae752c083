// What a pixel shows, and where a key press leads.
#include "objects/surface_point.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>

#include "calib/lens.h"
#include "tests/objects/placement_stage.h"

namespace pleinair::surface_point_test {
namespace {

using namespace placement_stage;

// At 1.7 m over (0, -6), looking north, 10 deg down.
Camera Eye() {
  const double down = kPi / 18.0;
  const glm::dvec3 right(1.0, 0.0, 0.0);
  const glm::dvec3 forward(0.0, std::cos(down), -std::sin(down));
  const glm::dmat3 world_from_camera(right, glm::cross(forward, right), forward);
  Camera camera;
  camera.intrinsics = {640, 480, 500.0, 500.0, 319.5, 239.5, {}};
  camera.camera_from_world = glm::dmat4(glm::transpose(world_from_camera));
  camera.camera_from_world[3] =
      glm::dvec4(-(glm::transpose(world_from_camera) * glm::dvec3(0.0, -6.0, 1.7)), 1.0);
  return camera;
}

glm::dvec2 PixelOf(const Camera& camera, const glm::dvec3& point_m) {
  return *ProjectToPixel(camera.intrinsics,
                         glm::dvec3(camera.camera_from_world * glm::dvec4(point_m, 1.0)));
}

TEST(SurfacePoint, APixelShowsWhatProjectsOntoIt) {
  const Mesh mesh = Floor().Box("wall", {-10, 3, 0}, {10, 3.2f, 4}).Done();
  const RayCaster caster(mesh);
  Camera camera = Eye();
  // A strong barrel as well: the corner of the picture is displaced by a fifth of its distance.
  for (const double k1 : {0.0, -0.25}) {
    camera.intrinsics.distortion[0] = k1;
    camera.intrinsics.distortion[1] = -0.1 * k1;
    std::mt19937 random(3);
    int floors = 0;
    int walls = 0;
    for (int i = 0; i < 500; ++i) {
      const glm::dvec2 pixel(random() % 640, random() % 480);
      const auto point = SurfaceAt(caster, mesh, camera, pixel);
      if (!point) continue;
      // Single precision of the ray, 10 m away and grazing.
      EXPECT_LT(glm::distance(PixelOf(camera, point->position_m), pixel), 0.01);
      const bool is_floor = point->group == "floor";
      (is_floor ? floors : walls) += 1;
      EXPECT_LT(glm::distance(point->normal, is_floor ? glm::dvec3(0, 0, 1) : glm::dvec3(0, -1, 0)),
                1e-12);
      EXPECT_LT(is_floor ? std::abs(point->position_m.z) : std::abs(point->position_m.y - 3.0),
                1e-12);
    }
    EXPECT_GT(floors, 100);
    EXPECT_GT(walls, 100);
  }
}

TEST(SurfacePoint, TheSkyTheUnderworldAndWhereTheLensEndsShowNothing) {
  const Mesh mesh = Floor().Done();
  const RayCaster caster(mesh);
  Camera camera = Eye();
  EXPECT_FALSE(SurfaceAt(caster, mesh, camera, {320.0, 0.0}));
  EXPECT_TRUE(SurfaceAt(caster, mesh, camera, {320.0, 479.0}));
  // Barrel distortion that folds back: no direction leads that far out.
  camera.intrinsics.distortion[0] = -0.5;
  EXPECT_FALSE(SurfaceAt(caster, mesh, camera, {320.0, 4000.0}));
  // All of the mesh lies behind the camera.
  camera = Eye();
  camera.camera_from_world[3] += glm::dvec4(0.0, 0.0, -100.0, 0.0);
  EXPECT_FALSE(SurfaceAt(caster, mesh, camera, {320.0, 240.0}));
  // Nothing at all.
  EXPECT_FALSE(SurfaceAt(RayCaster(Mesh{}), Mesh{}, Eye(), {320.0, 479.0}));
}

TEST(SurfacePoint, TheNearestSurfaceFacesTheEye) {
  const Mesh mesh = Floor().Quad("sheet", {5, -2, 1}, {9, -2, 1}, {9, 2, 1}, {5, 2, 1}).Done();
  const auto above = NearestSurface(mesh, {6.0, 1.0, 1.2}, {6.0, 0.0, 3.0});
  ASSERT_TRUE(above);
  EXPECT_EQ(above->group, "sheet");
  EXPECT_LT(glm::distance(above->position_m, {6.0, 1.0, 1.0}), 1e-12);
  EXPECT_EQ(above->normal, glm::dvec3(0, 0, 1));
  const auto below = NearestSurface(mesh, {4.5, 0.0, 0.9}, {6.0, 0.0, 0.5});
  ASSERT_TRUE(below);
  EXPECT_LT(glm::distance(below->position_m, {5.0, 0.0, 1.0}), 1e-12);  // At its edge.
  EXPECT_EQ(below->normal, glm::dvec3(0, 0, -1));
  EXPECT_FALSE(NearestSurface(Mesh{}, {0, 0, 0}, {0, 0, 1}));
}

}  // namespace
}  // namespace pleinair::surface_point_test

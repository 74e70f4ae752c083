#include "render/internal/screen_extent.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "ray_cast_reference.h"
#include "scene/ray_caster.h"
#include "test_scenes.h"

namespace pleinair::test::screen_extent_test {
namespace {

TEST(ScreenExtent, HoldsEveryPixelThatAMeshShowsIn) {
  const Camera camera = LookAt({4.0, -6.0, 2.0}, {0.0, 0.0, 1.0}, 160, 120, 130.0);
  for (const Mesh& mesh : {Sphere({0.5f, 0.0f, 1.0f}, 0.7f, 12),
                           Box({2.0f, -5.0f, 0.0f}, {6.0f, -3.0f, 5.0f}),
                           Ground(100.0f)}) {
    const ScreenExtent extent =
        ExtentOf(mesh.positions_m, mesh.triangles, camera.intrinsics, camera.camera_from_world);
    const Image<VisiblePoint> points = CastPicture(RayCaster(mesh), camera);
    double nearest = 1e9;
    PixelRect shown{{1000, 1000}, {0, 0}};
    for (int y = 0; y < points.height; ++y) {
      for (int x = 0; x < points.width; ++x) {
        if (!points.At(x, y).is_hit) continue;
        const glm::dvec4 in_camera =
            camera.camera_from_world * glm::dvec4(glm::dvec3(points.At(x, y).hit.position_m), 1.0);
        nearest = std::min(nearest, in_camera.z);
        shown.lower = glm::min(shown.lower, glm::ivec2(x, y));
        shown.upper = glm::max(shown.upper, glm::ivec2(x + 1, y + 1));
      }
    }
    EXPECT_LE(extent.nearest_m, nearest + 1e-4);
    EXPECT_GE(extent.nearest_m, 0.9 * nearest);  // Pixel centres miss the very nearest point.
    EXPECT_TRUE(glm::all(glm::lessThanEqual(extent.rect.lower, shown.lower)));
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(extent.rect.upper, shown.upper)));
    EXPECT_TRUE(glm::all(glm::lessThanEqual(shown.lower - extent.rect.lower, glm::ivec2(3))));
    EXPECT_TRUE(glm::all(glm::lessThanEqual(extent.rect.upper - shown.upper, glm::ivec2(3))));
  }
}

TEST(ScreenExtent, IsEmptyForWhatIsNotInView) {
  const Camera camera = LookAt({0.0, -5.0, 1.0}, {0.0, 0.0, 1.0}, 64, 48, 50.0);
  const Mesh behind = Sphere({0.0f, -10.0f, 1.0f}, 1.0f, 8);
  const ScreenExtent extent =
      ExtentOf(behind.positions_m, behind.triangles, camera.intrinsics, camera.camera_from_world);
  EXPECT_TRUE(extent.rect.Empty());
  EXPECT_TRUE(std::isinf(extent.nearest_m));
}

TEST(ShadowExtent, HoldsEveryPixelThatTheShadowCanFallOn) {
  const Camera camera = LookAt({6.0, -7.0, 3.0}, {0.0, 0.0, 1.0}, 160, 120, 110.0);
  const BoundingBox receivers{{-20.0f, -20.0f, 0.0f}, {20.0f, 20.0f, 6.0f}};
  const Mesh object = Box({-0.5f, -0.5f, 0.0f}, {0.5f, 0.5f, 2.0f});
  const Mesh room = Box(receivers.lower_m, receivers.upper_m);
  for (const double azimuth : {10.0, 80.0, 170.0, 260.0, 350.0}) {
    const glm::dvec3 to_sun = DirectionOf(azimuth, 25.0);
    const PixelRect rect = ShadowExtentOf(
        BoundingBoxOf(object), receivers, to_sun, camera.intrinsics, camera.camera_from_world);
    // Receivers at their farthest: the inside of their box.
    const Image<VisiblePoint> points = CastPicture(RayCaster(room), camera);
    const Gray8Image mask = ReferenceShadowMask(RayCaster(object), points, to_sun);
    int shadowed = 0;
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        if (mask.At(x, y) == 0) continue;
        ++shadowed;
        EXPECT_TRUE(x >= rect.lower.x && x < rect.upper.x && y >= rect.lower.y && y < rect.upper.y)
            << "azimuth " << azimuth << ", pixel " << x << " " << y;
      }
    }
    EXPECT_GT(shadowed, 5) << "azimuth " << azimuth;
    EXPECT_LT(rect.Width() * rect.Height(), 160 * 120) << "azimuth " << azimuth;
  }
}

TEST(ShadowExtent, IsAllOfThePictureInsideTheShadowAndNothingAboveIt) {
  const Camera camera = LookAt({0.0, -3.0, 0.5}, {0.0, 5.0, 0.5}, 64, 48, 50.0);
  const BoundingBox ground{{-20.0f, -20.0f, 0.0f}, {20.0f, 20.0f, 0.0f}};
  const BoundingBox roof{{-5.0f, -5.0f, 3.0f}, {5.0f, 5.0f, 3.5f}};
  EXPECT_EQ(
      ShadowExtentOf(roof, ground, {0.0, 0.0, 1.0}, camera.intrinsics, camera.camera_from_world),
      WholePicture(camera.intrinsics));
  EXPECT_TRUE(
      ShadowExtentOf(ground, roof, {0.0, 0.0, 1.0}, camera.intrinsics, camera.camera_from_world)
          .Empty());
}

}  // namespace
}  // namespace pleinair::test::screen_extent_test

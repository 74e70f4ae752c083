// Where objects' shadows fall, on a level ground seen from above.
#include "objects/shadow_places.h"

#include <cmath>

#include <tbb/global_control.h>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/objects/object_test_scenes.h"

namespace pleinair::shadow_places_test {
namespace {

constexpr int kSizePx = 64;
constexpr float kPixelM = 1.0f / 32.0f;
const glm::vec3 kToSun = glm::normalize(glm::vec3(0.5f, 0.0f, 1.0f));

// Of the ground z = 0, whose pixel (x, y) shows its metres (x - 31.5, 31.5 - y) / 32.
SurfaceView GroundView() {
  SurfaceView view;
  view.camera = FromAbove();
  view.region = Image<std::int32_t>(kSizePx, kSizePx, 0);
  view.position_world_m = RgbImage(kSizePx, kSizePx);
  view.normal_world = RgbImage(kSizePx, kSizePx, {0.0f, 0.0f, 1.0f});
  for (int y = 0; y < kSizePx; ++y) {
    for (int x = 0; x < kSizePx; ++x) {
      view.position_world_m.At(x, y) = {kPixelM * (static_cast<float>(x) - 31.5f),
                                        kPixelM * (31.5f - static_cast<float>(y)),
                                        0.0f};
    }
  }
  return view;
}

class ShadowPlacesTest : public testing::Test {
 protected:
  ShadowPlacesTest() {
    AddPlate({-4.0f, -4.0f}, {4.0f, 4.0f}, 0.0f, ground_);
    AddPlate({-0.5f, -0.5f}, {0.5f, 0.5f}, 0.4f, table_);
  }

  ShadowPlaces Places(const glm::vec3& to_sun, const SurfaceView& view) const {
    const PatchScene objects = PatchesOf(table_);
    return ShadowPlacesOf(
        SeeObjects(objects, FromAbove()), objects, RayCaster(ground_), view, to_sun);
  }
  // Where the object's pixel lies in the view.
  static glm::ivec2 AtOf(const ShadowPlaces& places, int x, int y) {
    const std::int32_t pixel = places.pixel.At(x, y);
    return {pixel % kSizePx, pixel / kSizePx};
  }

  Mesh ground_;
  Mesh table_;
};

// 0.4 m high, with a sun of slope 2 in the east: 0.2 m to the west.
TEST_F(ShadowPlacesTest, LieWhereTheSunsRayMeetsTheGround) {
  const PatchScene objects = PatchesOf(table_);
  const ObjectView seen = SeeObjects(objects, FromAbove());
  const ShadowPlaces places = Places(kToSun, GroundView());
  int found = 0;
  for (int y = 0; y < places.pixel.height; ++y) {
    for (int x = 0; x < places.pixel.width; ++x) {
      const ObjectView::Sample& sample = seen.samples.At(2 * x, 2 * y);
      if (sample.triangle == ObjectView::kNothing || places.pixel.At(x, y) < 0) continue;
      ++found;
      const glm::uvec3& corners = objects.mesh.triangles[sample.triangle];
      const glm::vec3& a = objects.mesh.positions_m[corners.x];
      const glm::vec3 at_m = a + sample.barycentric.x * (objects.mesh.positions_m[corners.y] - a) +
                             sample.barycentric.y * (objects.mesh.positions_m[corners.z] - a);
      const glm::ivec2 shadow = AtOf(places, x, y);
      EXPECT_NEAR(static_cast<float>(shadow.x), (at_m.x - 0.2f) / kPixelM + 31.5f, 0.51f);
      EXPECT_NEAR(static_cast<float>(shadow.y), 31.5f - at_m.y / kPixelM, 0.51f);
    }
  }
  EXPECT_GT(found, 800);
}

TEST_F(ShadowPlacesTest, AreNotSeenOutsideThePictureOrBehindThings) {
  // Slope 1/4: 1.6 m to the west, past the picture's edge at -1 m for most of the table.
  const ShadowPlaces outside = Places(glm::normalize(glm::vec3(4.0f, 0.0f, 1.0f)), GroundView());
  SurfaceView covered = GroundView();
  for (glm::vec3& at_m : covered.position_world_m.pixels) at_m.z = 0.2f;
  const ShadowPlaces behind = Places(kToSun, covered);
  int on_table = 0;
  for (std::size_t i = 0; i < outside.pixel.pixels.size(); ++i) {
    if (outside.pixel.pixels[i] == ShadowPlaces::kNothing) continue;
    ++on_table;
    EXPECT_EQ(outside.pixel.pixels[i], ShadowPlaces::kNotSeen);
    EXPECT_EQ(behind.pixel.pixels[i], ShadowPlaces::kNotSeen);
  }
  EXPECT_GT(on_table, 800);
}

TEST_F(ShadowPlacesTest, AreNothingOnFacesThatTheSunDoesNotReach) {
  const ShadowPlaces places = Places(glm::vec3(0.0f, 0.6f, -0.8f), GroundView());
  for (const std::int32_t pixel : places.pixel.pixels) EXPECT_EQ(pixel, ShadowPlaces::kNothing);
}

TEST_F(ShadowPlacesTest, DoNotDependOnThreads) {
  const ShadowPlaces places = Places(kToSun, GroundView());
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(Places(kToSun, GroundView()).pixel.pixels, places.pixel.pixels);
}

}  // namespace
}  // namespace pleinair::shadow_places_test

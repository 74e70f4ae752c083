#include "apps/object_sightings.h"

#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/vec3.hpp>

namespace pleinair::object_sightings_test {
namespace {

using testing::HasSubstr;
using testing::Optional;

// Looks down the world's +Z from the origin.
Camera CameraAtOrigin() {
  Camera camera;
  camera.intrinsics.width_px = 640;
  camera.intrinsics.height_px = 480;
  camera.intrinsics.fx_px = camera.intrinsics.fy_px = 500.0;
  camera.intrinsics.cx_px = 320.0;
  camera.intrinsics.cy_px = 240.0;
  return camera;
}

std::vector<VirtualObject> TriangleAround(const glm::vec3& middle_m, float half_side_m) {
  VirtualObject object;
  object.mesh.positions_m = {middle_m - glm::vec3(half_side_m, half_side_m, 0.0f),
                             middle_m + glm::vec3(half_side_m, -half_side_m, 0.0f),
                             middle_m + glm::vec3(half_side_m, half_side_m, 0.0f)};
  object.mesh.triangles = {{0, 1, 2}};
  return {object};
}

Composite Picture(PixelChange somewhere) {
  Composite composite;
  composite.change = Gray8Image(640, 480, static_cast<std::uint8_t>(PixelChange::kNone));
  composite.change.At(100, 100) = static_cast<std::uint8_t>(somewhere);
  return composite;
}

std::optional<std::string> NoteOnUnseen(const std::vector<VirtualObject>& objects) {
  ObjectSightings sightings;
  sightings.Add(CameraAtOrigin(), Picture(PixelChange::kScaled));
  sightings.Add(CameraAtOrigin(), Picture(PixelChange::kNone));
  return sightings.Note(objects);
}

TEST(ObjectSightings, SaysWhereUnseenObjectsAre) {
  EXPECT_THAT(NoteOnUnseen(TriangleAround({0.0f, 0.0f, -5.0f}, 0.5f)),
              Optional(HasSubstr("behind the camera")));
  EXPECT_THAT(NoteOnUnseen(TriangleAround({10.0f, 0.0f, 5.0f}, 0.5f)),
              Optional(HasSubstr("pixel (1320, 240), outside the picture of 640x480")));
  EXPECT_THAT(NoteOnUnseen(TriangleAround({0.0f, 0.0f, 5.0f}, 0.0005f)),
              Optional(HasSubstr("pixel (320, 240), smaller than a pixel")));
  EXPECT_THAT(NoteOnUnseen(TriangleAround({0.0f, 0.0f, 5.0f}, 0.5f)),
              Optional(HasSubstr("pixel (320, 240), probably hidden")));
}

TEST(ObjectSightings, SaysNothingOfObjectsThatAFrameShows) {
  const std::vector<VirtualObject> objects = TriangleAround({0.0f, 0.0f, -5.0f}, 0.5f);
  ObjectSightings sightings;
  sightings.Add(CameraAtOrigin(), Picture(PixelChange::kNone));
  sightings.Add(CameraAtOrigin(), Picture(PixelChange::kCovered));
  sightings.Add(CameraAtOrigin(), Picture(PixelChange::kNone));
  EXPECT_EQ(sightings.Note(objects), std::nullopt);
}

TEST(ObjectSightings, SaysNothingWithoutFramesOrObjects) {
  EXPECT_EQ(ObjectSightings().Note(TriangleAround({0.0f, 0.0f, -5.0f}, 0.5f)), std::nullopt);
  EXPECT_EQ(NoteOnUnseen({}), std::nullopt);
}

}  // namespace
}  // namespace pleinair::object_sightings_test

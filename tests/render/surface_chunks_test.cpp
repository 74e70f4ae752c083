#include "render/internal/surface_chunks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "render/internal/screen_extent.h"
#include "render/internal/view_projection.h"
#include "test_scenes.h"

namespace pleinair::test::surface_chunks_test {
namespace {

// Uneven ground around the camera, in triangles of 10 cm that are stored in no order.
Mesh Field(int squares_a_side) {
  Mesh mesh;
  const auto vertex = [&](int x, int y) {
    return static_cast<std::uint32_t>(y * (squares_a_side + 1) + x);
  };
  for (int y = 0; y <= squares_a_side; ++y) {
    for (int x = 0; x <= squares_a_side; ++x) {
      const glm::vec2 at(0.1f * static_cast<float>(x - squares_a_side / 2),
                         0.1f * static_cast<float>(y - squares_a_side / 2));
      mesh.positions_m.emplace_back(at, 0.3f * std::sin(3.0f * at.x) * std::cos(2.0f * at.y));
    }
  }
  for (int y = 0; y < squares_a_side; ++y) {
    for (int x = 0; x < squares_a_side; ++x) {
      mesh.triangles.emplace_back(vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1));
      mesh.triangles.emplace_back(vertex(x, y), vertex(x + 1, y + 1), vertex(x, y + 1));
    }
  }
  std::stable_sort(
      mesh.triangles.begin(), mesh.triangles.end(), [](const glm::uvec3& a, const glm::uvec3& b) {
        return a.x * 2654435761u < b.x * 2654435761u;
      });
  return mesh;
}

std::vector<Camera> Cameras() {
  return {LookAt({0.0, 0.0, 1.7}, {4.0, 1.0, 0.0}, 160, 120, 130.0),
          LookAt({3.0, -2.0, 1.2}, {3.0, -1.5, 0.0}, 160, 120, 400.0),
          LookAt({-9.0, -9.0, 1.5}, {-20.0, -20.0, 1.0}, 160, 120, 130.0)};
}

TEST(SurfaceChunks, WhatIsInViewIsDrawnAndMostOfTheRestIsNot) {
  for (const int squares : {80, 200}) {  // Fewer triangles than are sorted, and more.
    const Mesh field = Field(squares);
    const SurfaceChunks chunks(field.positions_m, field.triangles);
    ASSERT_EQ(chunks.Triangles().size(), field.triangles.size());
    for (const Camera& camera : Cameras()) {
      const glm::mat4 clip_from_world(ClipFromCamera(camera.intrinsics, 0.1) *
                                      camera.camera_from_world);
      std::vector<bool> drawn(field.triangles.size(), false);
      std::size_t count = 0;
      for (const auto& range : chunks.InView(clip_from_world)) {
        for (std::size_t i = 0; i < range.count; ++i) drawn[range.first + i] = true;
        count += range.count;
      }
      std::size_t in_view = 0;
      for (std::size_t i = 0; i < drawn.size(); ++i) {
        const glm::uvec3& v = chunks.Triangles()[i];
        const std::array corners_m{
            field.positions_m[v.x], field.positions_m[v.y], field.positions_m[v.z]};
        const std::array triangle{glm::uvec3(0, 1, 2)};
        const bool shows = std::isfinite(
            ExtentOf(corners_m, triangle, camera.intrinsics, camera.camera_from_world).nearest_m);
        in_view += shows ? 1 : 0;
        EXPECT_TRUE(drawn[i] || !shows) << i;
      }
      if (squares == 200) {
        EXPECT_LE(count, 2 * in_view + 6000) << "of " << drawn.size();
      }
    }
  }
}

TEST(SurfaceChunks, TheNearestPointInViewIsThatOfAllTriangles) {
  const Mesh field = Field(200);
  const SurfaceChunks chunks(field.positions_m, field.triangles);
  for (const Camera& camera : Cameras()) {
    EXPECT_EQ(
        chunks.NearestInViewM(camera.intrinsics, camera.camera_from_world),
        ExtentOf(field.positions_m, field.triangles, camera.intrinsics, camera.camera_from_world)
            .nearest_m);
  }
}

TEST(SurfaceChunks, OfNothingNothingIsInView) {
  const SurfaceChunks none({}, {});
  EXPECT_TRUE(none.InView(glm::mat4(1.0f)).empty());
  EXPECT_FALSE(
      std::isfinite(none.NearestInViewM(Cameras()[0].intrinsics, Cameras()[0].camera_from_world)));
}

}  // namespace
}  // namespace pleinair::test::surface_chunks_test

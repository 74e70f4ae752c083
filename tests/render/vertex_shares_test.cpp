// What pixels show of vertices, against rays through their samples.
#include "render/internal/vertex_shares.h"

#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "render/internal/view_projection.h"

namespace pleinair::test::vertex_shares_test {
namespace {

const CameraIntrinsics kLens{
    .width_px = 8, .height_px = 6, .fx_px = 7.0, .fy_px = 7.0, .cx_px = 3.5, .cy_px = 2.5};

// Five samples a pixel: in the middle, and 1/5 and 2/5 px from it.
const SampleLattice& Lattice() {
  static const SampleLattice lattice(2, {kLens.width_px, kLens.height_px});
  return lattice;
}
constexpr glm::dvec2 kPlaces[] = {{0.0, 0.0}, {0.4, 0.2}, {-0.2, 0.4}, {-0.4, -0.2}, {0.2, -0.4}};

struct DrawnTriangles {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<std::uint32_t> numbers;  // The triangle of each sample; 0: none.
};

std::vector<glm::vec4> SumOver(const DrawnTriangles& drawn,
                               std::span<const glm::vec3> at_vertices,
                               std::span<const glm::vec3> mirrored = {},
                               std::vector<bool> is_glossy = {}) {
  is_glossy.resize(drawn.positions.size(), false);
  const VertexShares shares({.lattice = Lattice(),
                             .triangle = drawn.numbers,
                             .clip_from_position = glm::mat4(Lattice().ClipFromPixelsClip() *
                                                             ClipFromCamera(kLens, 0.01)),
                             .positions = drawn.positions,
                             .triangles = drawn.triangles},
                            is_glossy);
  std::vector<glm::vec4> layer;
  shares.Sum(at_vertices, mirrored, layer);
  return layer;
}

std::vector<std::uint32_t> Everywhere(std::uint32_t number) {
  const glm::ivec2 size = Lattice().Size();
  return std::vector<std::uint32_t>(static_cast<std::size_t>(size.x * size.y), number);
}

// Whether a point of the triangle's plane is inside it.
bool IsInside(const std::vector<glm::vec3>& corners, const glm::dvec3& point) {
  const glm::dvec3 normal =
      glm::cross(glm::dvec3(corners[1] - corners[0]), glm::dvec3(corners[2] - corners[0]));
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3 edge(corners[(k + 1) % 3] - corners[k]);
    if (glm::dot(glm::cross(edge, point - glm::dvec3(corners[k])), normal) < 0.0) return false;
  }
  return true;
}

// With a vertex's own place as its value, a sample's is the point that it shows: the mean over a
// pixel is that of the rays through its samples. A corner of the second triangle lies behind the
// camera.
TEST(VertexShares, AreThoseOfTheRaysThroughThePixelsSamples) {
  const std::vector<glm::vec3> positions[] = {
      {{-9.0f, -6.0f, 4.0f}, {9.0f, -6.0f, 9.0f}, {0.0f, 14.0f, 6.0f}},
      {{0.0f, 0.3f, -20.0f}, {60.0f, 1.0f, 50.0f}, {-60.0f, 1.0f, 50.0f}}};
  for (const std::vector<glm::vec3>& corners : positions) {
    const std::vector<glm::vec4> layer = SumOver({corners, {{0, 1, 2}}, Everywhere(1)}, corners);
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(corners[1] - corners[0]), glm::dvec3(corners[2] - corners[0]));
    int met = 0;
    for (int y = 0; y < kLens.height_px; ++y) {
      for (int x = 0; x < kLens.width_px; ++x) {
        glm::dvec3 expected(0.0);
        bool is_shown = true;
        for (const glm::dvec2& place : kPlaces) {
          const glm::dvec3 ray((x + place.x - kLens.cx_px) / kLens.fx_px,
                               (y + place.y - kLens.cy_px) / kLens.fy_px,
                               1.0);
          const double depth = glm::dot(glm::dvec3(corners[0]), normal) / glm::dot(ray, normal);
          is_shown &= depth > 0.0 && IsInside(corners, depth * ray);
          expected += 0.2 * depth * ray;
        }
        if (!is_shown) continue;
        ++met;
        const glm::vec4& found = layer[static_cast<std::size_t>(y * kLens.width_px + x)];
        EXPECT_EQ(found.a, 1.0f);
        // Clip coordinates are floats, the farthest corner at 80 m.
        EXPECT_LT(glm::length(glm::dvec3(found) - expected), 1e-5 * 80.0) << x << ", " << y;
      }
    }
    EXPECT_GT(met, 15);
  }
}

TEST(VertexShares, CountSamplesOfSeveralTrianglesAndOfNone) {
  const std::vector<glm::vec3> positions{{-9.0f, -6.0f, 4.0f},
                                         {9.0f, -6.0f, 4.0f},
                                         {0.0f, 14.0f, 4.0f},
                                         {-9.0f, -6.0f, 5.0f},
                                         {9.0f, -6.0f, 5.0f},
                                         {0.0f, 14.0f, 5.0f}};
  std::vector<std::uint32_t> numbers = Everywhere(0);
  // One sample of pixel (0, 0) shows the first triangle and two show the second.
  for (const std::size_t sample : {0, 1, 2}) {
    const glm::ivec2 at = Lattice().Of({0, 0}) + Lattice().Offsets()[sample];
    numbers[static_cast<std::size_t>(at.y * Lattice().Size().x + at.x)] = sample == 0 ? 1 : 2;
  }
  const glm::vec3 first(1.0f, 2.0f, 3.0f);
  const glm::vec3 second(10.0f, 20.0f, 40.0f);
  const std::vector<glm::vec3> values{first, first, first, second, second, second};
  const std::vector<glm::vec3> mirrored(static_cast<std::size_t>(kLens.width_px * kLens.height_px),
                                        glm::vec3(8.0f, 0.0f, 0.0f));
  const std::vector<glm::vec4> layer = SumOver({positions, {{0, 1, 2}, {3, 4, 5}}, numbers},
                                               values,
                                               mirrored,
                                               {false, false, false, true, true, true});
  const glm::vec3 expected = 0.2f * first + 0.4f * second + 0.4f * glm::vec3(8.0f, 0.0f, 0.0f);
  EXPECT_LT(glm::length(glm::vec3(layer[0]) - expected), 1e-4f);
  EXPECT_EQ(layer[0].a, 0.6f);
  for (std::size_t i = 1; i < layer.size(); ++i) EXPECT_EQ(layer[i], glm::vec4(0.0f));
}

// OpenGL may let a sample show a triangle that it only touches.
TEST(VertexShares, OfATriangleSeenFromItsEdgeAreFiniteAndAddUp) {
  const std::vector<glm::vec3> positions{
      {0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 2.0f}, {0.0f, 0.0f, 2.0f}};
  const std::vector<glm::vec3> values(3, glm::vec3(5.0f));
  for (const glm::vec4& pixel : SumOver({positions, {{0, 1, 2}}, Everywhere(1)}, values)) {
    EXPECT_NEAR(pixel.g, 5.0f, 1e-5f);
  }
}

}  // namespace
}  // namespace pleinair::test::vertex_shares_test

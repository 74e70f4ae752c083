#include "datasets/sunlit_share.h"

#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace pleinair::sunlit_share_test {
namespace {

// Two triangles, counter-clockwise as the corners go round.
void AddQuad(Mesh& mesh,
             const std::array<glm::vec3, 4>& corners,
             const std::string& group,
             const Material& material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const glm::vec3& corner : corners) {
    mesh.positions_m.push_back(corner);
    mesh.normals.push_back(
        glm::normalize(glm::cross(corners[1] - corners[0], corners[3] - corners[0])));
  }
  for (const glm::uvec3& triangle : {glm::uvec3(0, 1, 2), glm::uvec3(0, 2, 3)}) {
    mesh.triangles.push_back(triangle + first);
    mesh.triangle_group.push_back(static_cast<std::uint32_t>(mesh.group_names.size()));
    mesh.triangle_material.push_back(static_cast<std::uint32_t>(mesh.materials.size()));
  }
  mesh.group_names.push_back(group);
  mesh.materials.push_back(material);
}

Material Named(const std::string& name) {
  Material material;
  material.name = name;
  return material;
}

// A floor 20 m square under a camera that looks straight down from 5 m: a 100 px picture of 10 m,
// 10 px a metre; image right is east, image down is south. A wall stands on x = 0, outside the
// camera's field (its top edge on), 2 m high.
class SunlitShareTest : public testing::Test {
 protected:
  SunlitShareTest() {
    sequence_.intrinsics = {100, 100, 50.0, 50.0, 49.5, 49.5, {}};
    sequence_.frames.resize(1);
    AddQuad(floor_and_wall_,
            {glm::vec3(-10, -10, 0),
             glm::vec3(10, -10, 0),
             glm::vec3(10, 10, 0),
             glm::vec3(-10, 10, 0)},
            "floor",
            Named("stone"));
    AddQuad(floor_and_wall_,
            {glm::vec3(0, -10, 0), glm::vec3(0, 10, 0), glm::vec3(0, 10, 2), glm::vec3(0, -10, 2)},
            "wall",
            Named("brick"));
    camera_.intrinsics = sequence_.intrinsics;
    camera_.camera_from_world =
        glm::dmat4({1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}, {0, 0, 5, 1});
  }

  Sequence sequence_;
  Mesh floor_and_wall_;
  Camera camera_;
};

// The sun at 45 deg in the west: the wall's shadow is 2 m wide, 20 of 100 columns.
TEST_F(SunlitShareTest, SeesTheShadowThatGeometrySays) {
  SunlitCounter counter(sequence_, floor_and_wall_);
  const SunlitShare share = counter.Count(camera_, {-std::sqrt(0.5), 0.0, std::sqrt(0.5)});
  EXPECT_EQ(share.diffuse_pixels, 100 * 100);
  EXPECT_NEAR(share.lit, 0.8, 0.01);
  EXPECT_TRUE(share.IsWellPosed());
  // At the zenith nothing is in shadow; below the horizon all is.
  EXPECT_NEAR(counter.Count(camera_, {0.0, 0.0, 1.0}).lit, 1.0, 1e-12);
  EXPECT_FALSE(counter.Count(camera_, {0.0, 0.0, 1.0}).IsWellPosed());
  EXPECT_EQ(counter.Count(camera_, {-0.8, 0.0, -0.6}).lit, 0.0);
}

TEST_F(SunlitShareTest, CountsDiffuseRegionsByGroupOrMaterial) {
  sequence_.diffuse_regions = {"stone"};
  EXPECT_EQ(SunlitCounter(sequence_, floor_and_wall_).Count(camera_, {0, 0, 1}).diffuse_pixels,
            100 * 100);
  sequence_.diffuse_regions = {"wall"};
  const SunlitShare none = SunlitCounter(sequence_, floor_and_wall_).Count(camera_, {0, 0, 1});
  EXPECT_EQ(none.diffuse_pixels, 0);
  EXPECT_FALSE(none.IsWellPosed());
}

TEST_F(SunlitShareTest, FollowsTheCamera) {
  SunlitCounter counter(sequence_, floor_and_wall_);
  const glm::dvec3 sun(-std::sqrt(0.5), 0.0, std::sqrt(0.5));
  counter.Count(camera_, sun);
  Camera moved = camera_;
  moved.camera_from_world[3].x = 5.0;  // The camera 5 m to the west: the shadow is out of sight.
  EXPECT_NEAR(counter.Count(moved, sun).lit, 1.0, 0.01);
  EXPECT_NEAR(counter.Count(camera_, sun).lit, 0.8, 0.01);
}

TEST_F(SunlitShareTest, FindsMirroringPixelsThatAreSeen) {
  Mesh object;
  Material chrome = Named("chrome");
  chrome.specular_reflectance = glm::vec3(0.85f);
  AddQuad(object,
          {glm::vec3(1.02f, 1.02f, 1),
           glm::vec3(3.02f, 1.02f, 1),
           glm::vec3(3.02f, 3.02f, 1),
           glm::vec3(1.02f, 3.02f, 1)},
          "ball",
          chrome);
  AddQuad(object,
          {glm::vec3(-3, 1, 1), glm::vec3(-1, 1, 1), glm::vec3(-1, 3, 1), glm::vec3(-3, 3, 1)},
          "statue",
          Named("plaster"));
  const auto specular = SpecularPixels({object}, RayCaster(floor_and_wall_), camera_);
  ASSERT_TRUE(specular);
  // At 4 m from the camera 12.5 px a metre, edges a quarter of a pixel off the centres: 25 px
  // square, and a pixel all round.
  int pixels = 0;
  for (const std::uint8_t value : specular->pixels) pixels += value;
  EXPECT_EQ(pixels, 27 * 27);
  EXPECT_EQ(specular->At(49 + 25, 50 - 25), 1);

  // Under the floor nothing is seen of it; without chrome there is nothing to see.
  for (glm::vec3& position : object.positions_m) position.z = -1.0f;
  const auto hidden = SpecularPixels({object}, RayCaster(floor_and_wall_), camera_);
  ASSERT_TRUE(hidden);
  EXPECT_EQ(*std::max_element(hidden->pixels.begin(), hidden->pixels.end()), 0);
  EXPECT_FALSE(SpecularPixels({floor_and_wall_}, RayCaster(floor_and_wall_), camera_));
}

}  // namespace
}  // namespace pleinair::sunlit_share_test

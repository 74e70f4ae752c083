// Receivers that stay on the surfaces.
#include "relight/transport/face_lattice.h"

#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/relight/probe_test_scenes.h"

namespace pleinair::face_lattice_test {
namespace {

// A square of 1 m, two patches that share a diagonal; face 0 and 2 look up.
PatchScene Square() {
  Mesh mesh;
  AddQuad(mesh, {0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f});
  return SceneOf(std::move(mesh));
}

TEST(FaceLattice, FacesOfOnePlaneShareWhatTheyMeetIn) {
  const PatchScene scene = Square();
  const FaceLattice lattice(scene, std::vector<std::uint16_t>{4, 0, 4, 0});
  // 5 x 5 points of a square: 15 of each triangle, 5 on the diagonal.
  EXPECT_EQ(lattice.Receivers().size(), 25u);
  EXPECT_TRUE(lattice.HasReceivers(0));
  EXPECT_FALSE(lattice.HasReceivers(1));
  for (const Receiver& receiver : lattice.Receivers()) {
    EXPECT_EQ(receiver.normal, glm::vec3(0.0f, 0.0f, 1.0f));
    // At the square's rim a little inside, so that they don't stand in a wall.
    EXPECT_GT(receiver.position_m.x, 0.0f);
    EXPECT_LT(receiver.position_m.y, 1.0f);
  }
}

// What is linear over the plane is blended without an error, where receivers stand on the spot.
TEST(FaceLattice, BlendsWhatIsLinear) {
  const PatchScene scene = Square();
  const FaceLattice lattice(scene, std::vector<std::uint16_t>{10, 0, 10, 0});
  for (int i = 0; i < 37; ++i) {
    for (int k = 0; k < 37; ++k) {
      const glm::vec3 point_m(
          0.11f + 0.021f * static_cast<float>(i), 0.11f + 0.021f * static_cast<float>(k), 0.0f);
      const std::size_t face = point_m.y < point_m.x ? 0 : 2;
      const auto around = lattice.Around(scene, face, point_m);
      float sum = 0.0f;
      glm::vec3 blended_m(0.0f);
      for (const FaceLattice::Weighted& at : around) {
        EXPECT_GE(at.weight, -1e-5f);
        sum += at.weight;
        blended_m += at.weight * lattice.Receivers()[at.receiver].position_m;
      }
      EXPECT_NEAR(sum, 1.0f, 1e-5f);
      EXPECT_LT(glm::distance(blended_m, point_m), 1e-5f) << point_m.x << ", " << point_m.y;
    }
  }
}

TEST(FaceLattice, APointAHairOutsideIsOnTheEdge) {
  const PatchScene scene = Square();
  const FaceLattice lattice(scene, std::vector<std::uint16_t>{3, 0, 0, 0});
  for (const glm::vec3& point_m : {glm::vec3(-1e-6f, -1e-6f, 0.0f),
                                   glm::vec3(1.0f + 1e-6f, 0.0f, 0.0f),
                                   glm::vec3(1.0f, 1.0f + 1e-6f, 0.0f),
                                   glm::vec3(0.5f, 0.5f, 0.0f)}) {
    float sum = 0.0f;
    for (const FaceLattice::Weighted& at : lattice.Around(scene, 0, point_m)) {
      EXPECT_LT(at.receiver, lattice.Receivers().size());
      EXPECT_GE(at.weight, -1e-5f);
      sum += at.weight;
    }
    EXPECT_NEAR(sum, 1.0f, 1e-5f);
  }
}

TEST(FaceLattice, RefusesAnotherNumberOfFaces) {
  const PatchScene scene = Square();
  EXPECT_THROW(FaceLattice(scene, std::vector<std::uint16_t>(3, 1)), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::face_lattice_test

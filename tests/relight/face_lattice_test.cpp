// Receivers that stay on the surfaces.
#include "relight/transport/face_lattice.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

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

// A square of 2 m in 2 x 64 x 64 triangles, whose vertices but the rim's are off the plane.
PatchScene FineSquare(float bump_m) {
  Mesh mesh;
  constexpr int kSteps = 64;
  const auto at = [&](int x, int y) {
    const bool is_inside = x > 0 && y > 0 && x < kSteps && y < kSteps;
    const float up_m = is_inside ? bump_m * static_cast<float>((7 * x + 3 * y) % 5 - 2) : 0.0f;
    return glm::vec3(static_cast<float>(x) / 32.0f, static_cast<float>(y) / 32.0f, up_m);
  };
  for (int x = 0; x < kSteps; ++x) {
    for (int y = 0; y < kSteps; ++y) {
      AddQuad(mesh, at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1));
    }
  }
  mesh.materials.resize(1);
  mesh.group_names = {"scene"};
  return BuildPatchScene(mesh, {.patch_size_m = 0.5, .growth_per_m = 0.0, .extend_ground = false});
}

// Small triangles ask for no more receivers than their patches' size does: 0.125 m apart, and one
// spacing over each border, less in small patches of corners. They stand on triangles, and blend
// what is linear to a triangle's size.
TEST(FaceLattice, JoinedPatchesShareAGrid) {
  for (const float bump_m : {0.0f, 0.002f}) {
    const PatchScene scene = FineSquare(bump_m);
    ASSERT_FALSE(scene.several.Empty());
    std::vector<std::uint16_t> parts(scene.SideCount(), 0);
    for (std::size_t side = 0; side < parts.size(); side += 2) parts[side] = 2;
    const FaceLattice lattice(scene, parts);
    EXPECT_GE(lattice.Receivers().size(), 17u * 17u);
    EXPECT_LE(lattice.Receivers().size(), 20u * 20u);
    for (std::size_t i = 0; i < lattice.Receivers().size(); ++i) {
      const Receiver& receiver = lattice.Receivers()[i];
      EXPECT_GT(receiver.normal.z, 0.99f);
      const auto hit = scene.caster.Intersect(receiver.position_m + glm::vec3(0.0f, 0.0f, 1.0f),
                                              glm::vec3(0.0f, 0.0f, -1.0f));
      ASSERT_TRUE(hit);
      EXPECT_LT(glm::distance(hit->position_m, receiver.position_m), 1e-4f);
      EXPECT_EQ(scene.FaceOfHit(*hit, {0.0f, 0.0f, -1.0f}),
                scene.FaceOfSide(static_cast<std::int32_t>(lattice.SideOfReceiver()[i])));
    }
    for (int i = 0; i < 61; ++i) {
      const glm::vec3 above_m(0.2f + 0.026f * static_cast<float>(i),
                              0.3f + 0.017f * static_cast<float>((i * 23) % 61),
                              1.0f);
      const auto hit = scene.caster.Intersect(above_m, {0.0f, 0.0f, -1.0f});
      ASSERT_TRUE(hit);
      const std::size_t side = 2 * hit->triangle;
      EXPECT_TRUE(lattice.HasReceivers(side));
      EXPECT_FALSE(lattice.HasReceivers(side + 1));
      float sum = 0.0f;
      glm::vec3 blended_m(0.0f);
      const auto own = lattice.ReceiversOf(side);
      for (const FaceLattice::Weighted& at : lattice.Around(scene, side, hit->position_m)) {
        EXPECT_GE(at.weight, 0.0f);
        EXPECT_NE(std::find(own.begin(), own.end(), at.receiver), own.end());
        sum += at.weight;
        blended_m += at.weight * lattice.Receivers()[at.receiver].position_m;
      }
      EXPECT_NEAR(sum, 1.0f, 1e-5f);
      EXPECT_LT(glm::distance(blended_m, hit->position_m), 0.04f);
    }
  }
}

TEST(FaceLattice, WhatIsKeptOfTheLastSideChangesNothing) {
  const PatchScene scene = Square();
  const FaceLattice lattice(scene, std::vector<std::uint16_t>{3, 2, 5, 1});
  FaceLattice::LastSide last_side(lattice, scene);
  for (const std::size_t side : {0u, 0u, 3u, 2u, 2u, 1u, 0u}) {
    const glm::vec3 point_m = side < 2 ? glm::vec3(0.7f, 0.2f, 0.0f) : glm::vec3(0.3f, 0.9f, 0.0f);
    const auto kept = last_side.Around(side, point_m);
    const auto fresh = lattice.Around(scene, side, point_m);
    for (std::size_t k = 0; k < kept.size(); ++k) {
      EXPECT_EQ(kept[k].receiver, fresh[k].receiver) << side;
      EXPECT_EQ(kept[k].weight, fresh[k].weight) << side;
    }
  }
}

TEST(FaceLattice, APointAMicrometreOutsideIsOnTheEdge) {
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

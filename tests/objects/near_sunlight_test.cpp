// Sunlight close to objects against form factors.
#include "objects/near_sunlight.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <tbb/global_control.h>

#include <gtest/gtest.h>

namespace pleinair::near_sunlight_test {
namespace {

const DirectionalLight kZenith{{0.0, 0.0, 1.0}, {}, 0.0};
constexpr float kAlbedo = 0.4f;

PatchScene Square(float half_side_m, float height_m) {
  PatchScene scene;
  scene.mesh.positions_m = {{-half_side_m, -half_side_m, height_m},
                            {half_side_m, -half_side_m, height_m},
                            {half_side_m, half_side_m, height_m},
                            {-half_side_m, half_side_m, height_m}};
  scene.mesh.normals.assign(4, {0.0f, 0.0f, 1.0f});
  scene.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.caster = RayCaster(scene.mesh);
  scene.face_albedo_rgb.assign(4, glm::vec3(kAlbedo));
  return scene;
}

// Form factor of a parallel square of half side 1 m, seen from 1 m over its middle.
double FormFactor() {
  const double b = 1.0 / std::sqrt(2.0);
  return 4.0 / std::numbers::pi * b * std::atan(b);
}

const std::vector<Receiver> kUnderLid{{{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, -1.0f}}};

// A lid of 2 m, a metre over lit ground with the sun in the zenith, has a dark square of its own
// size beneath it; farther off, the ground is what its patch says. 4096 stratified rays: 1 / 64 at
// the worst.
TEST(NearSunlight, AnObjectSeesItsOwnShadow) {
  const PatchScene ground = Square(50.0f, 0.0f);
  const PatchScene lid = Square(1.0f, 1.0f);
  const NearSunlight near(ground, lid, kUnderLid, {.rays_per_receiver = 4096});
  const std::vector<glm::vec3> lit(4, glm::vec3(1.0f));
  const glm::vec3 change = near.Change(ground, lid, kZenith, lit)[0];
  EXPECT_NEAR(change.g / kAlbedo, -FormFactor(), 0.016);
}

// Patches that were treated as dark, as if a real shadow lay over all of them, are lit where they
// are near: within the reach of the lid, but for its shadow.
TEST(NearSunlight, APatchsMeanGivesWayToThePlace) {
  const PatchScene ground = Square(50.0f, 0.0f);
  const PatchScene lid = Square(1.0f, 1.0f);
  const NearSunlight near(ground, lid, kUnderLid, {.rays_per_receiver = 4096, .reach = 1000.0});
  const std::vector<glm::vec3> dark(4, glm::vec3(0.0f));
  const glm::vec3 change = near.Change(ground, lid, kZenith, dark)[0];
  EXPECT_NEAR(change.g / kAlbedo, 1.0 - FormFactor(), 0.016);
}

TEST(NearSunlight, FarSurfacesAreLeftToTheirPatches) {
  const PatchScene ground = Square(50.0f, 0.0f);
  const PatchScene lid = Square(1.0f, 20.0f);
  const std::vector<Receiver> receiver{{{0.0f, 0.0f, 20.0f}, {0.0f, 0.0f, -1.0f}}};
  const NearSunlight near(ground, lid, receiver);
  const std::vector<glm::vec3> dark(4, glm::vec3(0.0f));
  EXPECT_EQ(near.Change(ground, lid, kZenith, dark)[0], glm::vec3(0.0f));
}

TEST(NearSunlight, DoesNotDependOnThreads) {
  const PatchScene ground = Square(50.0f, 0.0f);
  const PatchScene lid = Square(1.0f, 1.0f);
  std::vector<Receiver> receivers;
  for (int i = 0; i < 100; ++i) {
    receivers.push_back({{0.02f * static_cast<float>(i) - 1.0f, 0.0f, 1.0f}, {0.0f, 0.0f, -1.0f}});
  }
  const std::vector<glm::vec3> lit(4, glm::vec3(1.0f));
  const auto make = [&] {
    return NearSunlight(ground, lid, receivers).Change(ground, lid, kZenith, lit);
  };
  const std::vector<glm::vec3> two = make();
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(make(), two);
}

TEST(NearSunlightHardCases, NoObjectsNoNormalsAndNoSunAreHarmless) {
  const PatchScene ground = Square(50.0f, 0.0f);
  PatchScene none;
  const std::vector<glm::vec3> lit(4, glm::vec3(1.0f));
  EXPECT_EQ(NearSunlight(ground, none, kUnderLid).Change(ground, none, kZenith, lit)[0],
            glm::vec3(0.0f));
  const PatchScene lid = Square(1.0f, 1.0f);
  const std::vector<Receiver> no_normal{{{0.0f, 0.0f, 0.5f}, glm::vec3(0.0f)}};
  EXPECT_EQ(NearSunlight(ground, lid, no_normal).Change(ground, lid, kZenith, lit)[0],
            glm::vec3(0.0f));
  // Below the horizon nothing shines, and nothing was taken to.
  const std::vector<glm::vec3> dark(4, glm::vec3(0.0f));
  const DirectionalLight night{{0.0, 0.0, -1.0}, {}, 0.005};
  EXPECT_EQ(NearSunlight(ground, lid, kUnderLid).Change(ground, lid, night, dark)[0],
            glm::vec3(0.0f));
  EXPECT_THROW(NearSunlight(ground, lid, kUnderLid).Change(ground, lid, kZenith, {}),
               std::invalid_argument);
  EXPECT_THROW(NearSunlight(ground, lid, kUnderLid, {.rays_per_receiver = 0}),
               std::invalid_argument);
  EXPECT_THROW(NearSunlight(ground, lid, kUnderLid, {.reach = -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::near_sunlight_test

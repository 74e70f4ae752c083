#include "relight/transport/internal/region_irradiance.h"

#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "relight/transport/sky_visibility.h"
#include "relight/transport/transport.h"
#include "tests/relight/window_room.h"
#include "tests/scene/region_light.h"

namespace pleinair::region_irradiance_test {
namespace {

using internal::RegionIrradiance;

constexpr int kRays = 32768;

std::vector<float> OfAllFaces(const PatchScene& scene,
                              const PatchTransport& transport,
                              const SkyRegions& regions,
                              int rays) {
  return RegionIrradiance(
      scene, transport.Points(), {regions, rays, 1}, {0, scene.FaceCount()}, {});
}

PatchTransport ExposedTransport(const PatchScene& scene) {
  GatherOptions options;
  options.rays_per_receiver = 256;
  options.from_exposed_parts = true;
  return {scene, options};
}

// 0.5 %: an even quadrature of 1024 directions a region, of which the lowest span a wide range of
// cosines.
TEST(RegionIrradiance, AnOpenGroundGetsAllOfEachRegion) {
  Mesh mesh;
  AddGround(mesh, 10.0f);
  const PatchScene scene = SceneOf(std::move(mesh));
  for (const SkyRegions& regions : {SkyRegions(), SkyRegions(1, 1), SkyRegions(3, 5)}) {
    const std::vector<float> irradiance = OfAllFaces(
        scene, ExposedTransport(scene), regions, 1024 * static_cast<int>(regions.Count()));
    for (std::size_t region = 0; region < regions.Count(); ++region) {
      const double expected = HorizontalIrradiance(regions, region);
      EXPECT_NEAR(irradiance[region], expected, 0.005 * expected) << region;
      EXPECT_EQ(irradiance[regions.Count() + region], 0.0f);  // The lower side.
    }
  }
}

// Rays that are not cast because neighbours see all or nothing, against the same number all cast,
// over the faces inside. 7 %: the noise of 512 rays a region on either side, of which a tenth goes
// through the window. 1 %: of the sum over all faces and regions.
TEST(RegionIrradiance, RaysLeftOutAreNotMissed) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 1.5);
  const PatchTransport transport = ExposedTransport(scene);
  const std::vector<float> found = OfAllFaces(scene, transport, SkyRegions(), kRays);
  const auto directions = std::make_shared<SkyDirections>(SkyRegions(), kRays / 64, 9);
  const std::vector<float> expected =
      SkyVisibility::OfFaces(scene, transport.Points(), directions).FromRegions();
  double error2 = 0.0, size2 = 0.0, sum = 0.0, expected_sum = 0.0;
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    const glm::uvec3& v = scene.mesh.triangles[face / 2];
    const std::vector<glm::vec3>& at = scene.mesh.positions_m;
    const glm::vec3 middle = (at[v.x] + at[v.y] + at[v.z]) / 3.0f + 0.01f * scene.FaceNormal(face);
    if (middle.x < 0.0f || middle.x > 4.0f || middle.y < 0.0f || middle.y > 4.0f) continue;
    if (middle.z < 0.0f || middle.z > 3.0f) continue;
    for (std::size_t i = 64 * face; i < 64 * (face + 1); ++i) {
      error2 += std::pow(found[i] - expected[i], 2.0);
      size2 += std::pow(expected[i], 2.0);
      sum += found[i];
      expected_sum += expected[i];
    }
  }
  EXPECT_GT(expected_sum, 0.0);
  EXPECT_LT(std::sqrt(error2 / size2), 0.07);
  EXPECT_NEAR(sum / expected_sum, 1.0, 0.01);
}

TEST(RegionIrradiance, FacesMayBeDealtOutAsOneLikes) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 1.5);
  const PatchTransport transport = ExposedTransport(scene);
  const SkyRegions regions;
  const std::vector<float> whole = OfAllFaces(scene, transport, regions, 4096);
  std::vector<float> joined;
  for (std::size_t first = 0; first < scene.FaceCount();) {
    const std::size_t last = std::min(scene.FaceCount(), first + 150);
    const std::vector<float> part =
        RegionIrradiance(scene, transport.Points(), {regions, 4096, 1}, {first, last}, {});
    joined.insert(joined.end(), part.begin(), part.end());
    first = last;
  }
  EXPECT_EQ(joined, whole);
}

TEST(RegionIrradiance, RefusesWhatMakesNoSense) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 3.0);
  const PatchTransport transport = ExposedTransport(scene);
  EXPECT_THROW(OfAllFaces(scene, transport, SkyRegions(), 0), std::invalid_argument);
  EXPECT_THROW(OfAllFaces(Yard(), transport, SkyRegions(), 64), std::invalid_argument);
  EXPECT_THROW(RegionIrradiance(scene, transport.Points(), {SkyRegions(), 64, 1}, {2, 1}, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::region_irradiance_test

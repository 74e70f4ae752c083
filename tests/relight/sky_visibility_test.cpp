#include "relight/transport/sky_visibility.h"

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/relight/window_room.h"
#include "tests/scene/region_light.h"

namespace pleinair::sky_visibility_test {
namespace {

const glm::vec3 kUp(0.0f, 0.0f, 1.0f);

std::shared_ptr<const SkyDirections> Directions(const SkyRegions& regions, int per_region) {
  return std::make_shared<SkyDirections>(regions, per_region);
}

// A lattice of n points has an error of some 1 / n in the mean of a smooth function, times how much
// it varies: over the lowest band from nothing to twice the mean.
TEST(SkyVisibility, AnOpenPlaneGetsEachRegionsClosedForm) {
  const PatchScene nothing = SceneOf({});
  for (const SkyRegions& regions : {SkyRegions(), SkyRegions(1, 1), SkyRegions(7, 5)}) {
    const SkyVisibility open(nothing, std::array{Receiver{{}, kUp}}, Directions(regions, 256));
    const std::vector<float> irradiance = open.FromRegions();
    double sum = 0.0;
    for (std::size_t region = 0; region < regions.Count(); ++region) {
      const double expected = HorizontalIrradiance(regions, region);
      EXPECT_NEAR(irradiance[region], expected, expected * 4.0 / 256.0) << region;
      sum += irradiance[region];
    }
    EXPECT_NEAR(sum, std::numbers::pi, 0.01 * std::numbers::pi);
  }
}

// The regions' sum is the sky of radiance 1 everywhere: the same rays, added in another order.
TEST(SkyVisibility, RegionsAddUpToTheWholeSky) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 1.0);
  const auto directions = Directions(SkyRegions(), 64);
  const std::array receivers{Receiver{{2.0f, 1.0f, 0.0f}, kUp},
                             Receiver{{2.0f, 4.0f, 1.0f}, {0.0f, -1.0f, 0.0f}}};
  const SkyVisibility visibility(scene, receivers, directions);
  const std::vector<float> of_regions = visibility.FromRegions();
  const std::vector<glm::vec3> white(directions->Directions().size(), glm::vec3(1.0f));
  const std::vector<glm::vec3> of_sky = visibility.FromRadiance(white);
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const double sum = std::accumulate(&of_regions[64 * i], &of_regions[64 * i] + 64, 0.0);
    EXPECT_NEAR(of_sky[i].y, sum, 1e-6);
    EXPECT_GT(sum, 0.01);
  }
}

// Rays that are passed over, because the first few say that a region is hidden or open all over,
// must not change what faces get: against all of them cast from the faces' middles, as means over
// the floor. 2 %: 16 x 256 rays of which a tenth go through the window.
TEST(SkyVisibility, PassingOverRaysKeepsTheFloorsLight) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 0.6);
  const PatchTransport transport(scene, {.rays_per_receiver = 64, .from_exposed_parts = true});
  const auto directions = Directions(SkyRegions(), 256);
  const std::vector<float> of_faces =
      SkyVisibility::OfFaces(scene, transport.Points(), directions).FromRegions();
  std::vector<Receiver> middles;
  std::vector<std::size_t> faces;
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    const glm::uvec3& v = scene.mesh.triangles[face / 2];
    const glm::vec3 middle =
        (scene.mesh.positions_m[v.x] + scene.mesh.positions_m[v.y] + scene.mesh.positions_m[v.z]) /
        3.0f;
    if (scene.FaceNormal(face).z < 0.5f || std::abs(middle.z) > 0.01f) continue;
    if (middle.x < 0.3f || middle.x > 3.7f || middle.y < 0.3f || middle.y > 3.7f) continue;
    middles.push_back({middle, kUp});
    faces.push_back(face);
  }
  ASSERT_GT(faces.size(), 50u);
  const std::vector<float> of_middles = SkyVisibility(scene, middles, directions).FromRegions();
  double sum = 0.0;
  double reference = 0.0;
  double error2 = 0.0;
  double reference2 = 0.0;
  for (std::size_t region = 0; region < 64; ++region) {
    double of_region = 0.0;
    double reference_of_region = 0.0;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      of_region += of_faces[64 * faces[i] + region];
      reference_of_region += of_middles[64 * i + region];
    }
    sum += of_region;
    reference += reference_of_region;
    error2 += std::pow(of_region - reference_of_region, 2.0);
    reference2 += std::pow(reference_of_region, 2.0);
  }
  EXPECT_NEAR(sum / reference, 1.0, 0.01);
  EXPECT_LT(std::sqrt(error2 / reference2), 0.02);
}

TEST(SkyVisibility, RefusesWhatMakesNoSense) {
  EXPECT_THROW(SkyDirections(SkyRegions(), 0), std::invalid_argument);
  EXPECT_THROW(SkyDirections(SkyRegions(), 1 << 20), std::invalid_argument);
  const PatchScene scene = SceneOf({});
  const SkyVisibility visibility(
      scene, std::array{Receiver{{}, kUp}}, Directions(SkyRegions(1, 1), 8));
  EXPECT_THROW(visibility.FromRadiance({}), std::invalid_argument);
  EXPECT_THROW(SkyVisibility::OfFaces(Yard(), {}, Directions(SkyRegions(), 1)),
               std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::sky_visibility_test

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <glm/geometric.hpp>

#include "relight/transport/transport.h"
#include "scene/lighting.h"
#include "tests/relight/probe_test_scenes.h"
#include "tests/relight/solve_sky.h"

namespace pleinair::transport_hard_cases_test {
namespace {

const glm::vec3 kUp(0.0f, 0.0f, 1.0f);

// Three standard errors of a share p from n independent rays; a lattice does better.
double ThreeSigma(double p, int rays) { return 3.0 * std::sqrt(p * (1.0 - p) / rays); }

double AmbientWeight(const PatchScene& scene, const Receiver& receiver, int rays) {
  const GatheredRays gathered(scene, std::array{receiver}, {.rays_per_receiver = rays});
  return gathered.FromSky(*MakeUniformSkyShape())[0].x;
}

TEST(TransportHardCases, WhiteSkyOverAnOpenPlaneGivesExactlyOne) {
  Mesh mesh;
  AddGround(mesh, 1000.0f);
  const PatchScene scene = SceneOf(std::move(mesh));
  for (const int rays : {1, 7, 256, 4096}) {
    EXPECT_NEAR(AmbientWeight(scene, {{3.0f, -2.0f, 0.0f}, kUp}, rays), 1.0, 1e-6) << rays;
  }
}

// Between two parallel walls of height h, w apart, a point of the floor's middle sees
// c = sin(atan(w / 2 / h)) of a white sky; the walls are 400 m long for 8 m of width, which leaves
// (w / length)^2 = 4e-4 at the ends.
TEST(TransportHardCases, WhiteSkyOverACanyonHasItsClosedForm) {
  for (const float height_m : {1.0f, 4.0f, 20.0f}) {
    Mesh mesh;
    AddGround(mesh, 200.0f);
    AddQuad(mesh, {4, -200, 0}, {4, 200, 0}, {4, 200, height_m}, {4, -200, height_m});
    AddQuad(mesh, {-4, -200, 0}, {-4, 200, 0}, {-4, 200, height_m}, {-4, -200, height_m});
    const PatchScene scene = SceneOf(std::move(mesh));
    const double expected = std::sin(std::atan2(4.0, height_m));
    EXPECT_NEAR(AmbientWeight(scene, {{0.0f, 0.0f, 0.0f}, kUp}, 1024),
                expected,
                ThreeSigma(expected, 1024) + 4e-4)
        << height_m;
  }
}

// The middle of a round pit's floor: c = R^2 / (R^2 + H^2). 64 corners: the mean radius is 0.9992
// R.
TEST(TransportHardCases, WhiteSkyInARoundPitHasItsClosedForm) {
  for (const float depth_m : {0.5f, 2.0f, 6.0f}) {
    Mesh mesh;
    AddGround(mesh, 3.0f, -depth_m);
    constexpr int kCorners = 64;
    for (int i = 0; i < kCorners; ++i) {
      const float from = 2.0f * std::numbers::pi_v<float> * static_cast<float>(i) / kCorners;
      const float to = 2.0f * std::numbers::pi_v<float> * static_cast<float>(i + 1) / kCorners;
      const glm::vec3 a(2.0f * std::cos(from), 2.0f * std::sin(from), 0.0f);
      const glm::vec3 b(2.0f * std::cos(to), 2.0f * std::sin(to), 0.0f);
      const glm::vec3 deep(0.0f, 0.0f, -depth_m);
      AddQuad(mesh, a + deep, b + deep, b, a);
    }
    const PatchScene scene = SceneOf(std::move(mesh));
    const double expected = 4.0 / (4.0 + static_cast<double>(depth_m) * depth_m);
    EXPECT_NEAR(AmbientWeight(scene, {{0.0f, 0.0f, -depth_m}, kUp}, 1024),
                expected,
                ThreeSigma(expected, 1024) + 0.002)
        << depth_m;
  }
}

TEST(TransportHardCases, SameBitsForAnyNumberOfThreads) {
  const PatchScene scene = Yard();
  const glm::dvec3 sun = glm::normalize(glm::dvec3(0.4, -0.3, 0.5));
  const auto solve = [&] {
    const PatchTransport transport(scene, {.rays_per_receiver = 64});
    std::vector<glm::vec3> radiosity =
        SolveSky(transport, scene, *MakeUniformSkyShape(), kAllBounces).radiosity;
    const FaceLight of_sun = transport.SolveSun(scene, sun, 0.005, kAllBounces);
    radiosity.insert(radiosity.end(), of_sun.radiosity.begin(), of_sun.radiosity.end());
    return radiosity;
  };
  const std::vector<glm::vec3> many = solve();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(solve(), many);
}

TEST(TransportHardCases, OnePatchAndNoPatchSolve) {
  Mesh mesh;
  AddQuad(mesh, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  mesh.triangles.pop_back();
  mesh.triangle_group.pop_back();
  mesh.triangle_material.pop_back();
  const PatchScene one = SceneOf(std::move(mesh), glm::vec3(0.25f));
  const FaceLight light =
      SolveSky(PatchTransport(one, {}), one, *MakeUniformSkyShape(), kAllBounces);
  EXPECT_NEAR(light.radiosity[0].x, 0.25f, 1e-6f);
  EXPECT_EQ(light.radiosity[1], glm::vec3(0.0f));
  const PatchScene none = SceneOf({});
  EXPECT_TRUE(SolveSky(PatchTransport(none, {}), none, *MakeUniformSkyShape(), kAllBounces)
                  .radiosity.empty());
}

// Rays along the seam of touching patches, from their very corners, and from slivers of 10^4:1: all
// see what an open plane sees.
TEST(TransportHardCases, SeamsCornersAndSliversDoNotLeak) {
  Mesh mesh;
  for (int i = 0; i < 20; ++i) {
    const float y = 0.001f * static_cast<float>(i);
    AddQuad(mesh, {-5, y, 0}, {5, y, 0}, {5, y + 0.001f, 0}, {-5, y + 0.001f, 0});
  }
  const PatchScene scene = SceneOf(std::move(mesh));
  const PatchTransport transport(scene, {.rays_per_receiver = 64});
  for (const glm::vec3& c : transport.DirectFromSky(*MakeUniformSkyShape())) {
    EXPECT_TRUE(std::abs(c.x - 1.0f) < 1e-6f || c.x == 0.0f) << c.x;  // Upper and lower faces.
  }
  for (const glm::vec3& corner : scene.mesh.positions_m) {
    EXPECT_NEAR(AmbientWeight(scene, {corner, kUp}, 64), 1.0, 1e-6);
  }
}

// The sun's light on a wall's patches and floor may change by no more per 0.1 deg than its cosine
// and the shadow's edge make of it: 6 points a patch, of some 200 patches.
TEST(TransportHardCases, SunlightChangesGraduallyPastARoofTheHorizonAndTheZenith) {
  Mesh mesh;
  AddGround(mesh, 10.0f);
  AddBox(mesh, {1.0f, -4.0f, 0.0f}, {4.0f, 4.0f, 3.0f});
  mesh.materials.resize(1);
  mesh.group_names = {"scene"};
  const PatchScene scene =
      BuildPatchScene(mesh, {.patch_size_m = 1.5, .growth_per_m = 0.0, .extend_ground = false});
  const PatchTransport transport(scene, {.rays_per_receiver = 1});
  double whole_m2 = 0.0;
  for (std::size_t i = 0; i < scene.mesh.triangles.size(); ++i) whole_m2 += scene.PatchAreaM2(i);
  const auto power = [&](double elevation_deg) {
    const double elevation = elevation_deg * std::numbers::pi / 180.0;
    const auto direct = transport.DirectFromSun(
        scene, {std::cos(elevation), 0.1, std::sin(elevation)}, kMeanSunAngularRadiusRad);
    double sum = 0.0;
    for (std::size_t face = 0; face < direct.size(); ++face) {
      sum += direct[face].x * scene.PatchAreaM2(face / 2);
    }
    return sum / whole_m2;
  };
  for (const auto& [from_deg, to_deg] : {std::pair{-1.0, 2.0}, {40.0, 46.0}, {87.0, 93.0}}) {
    double previous = power(from_deg);
    for (double elevation = from_deg + 0.1; elevation <= to_deg; elevation += 0.1) {
      const double now = power(elevation);
      // 0.1 deg turns n.l by 0.0017; a shadow 3 / tan(e) long moves by up to 0.4 m where the sun is
      // at 2 deg, over floor that is lit at a grazing 0.03.
      EXPECT_NEAR(now, previous, 0.02) << elevation;
      previous = now;
    }
  }
  EXPECT_EQ(power(-1.0), 0.0);
}

TEST(TransportHardCases, ASunBelowTheHorizonLightsNothing) {
  const PatchScene scene = Yard();
  const PatchTransport transport(scene, {.rays_per_receiver = 16});
  const FaceLight light = transport.SolveSun(
      scene, glm::normalize(glm::dvec3(1.0, 0.2, -0.1)), kMeanSunAngularRadiusRad, kAllBounces);
  for (const glm::vec3& radiosity : light.radiosity) EXPECT_EQ(radiosity, glm::vec3(0.0f));
}

TEST(TransportHardCases, AReceiverWithoutANormalSeesNothing) {
  const PatchScene scene = Yard();
  const GatheredRays rays(scene, std::array{Receiver{{0, 0, 1}, glm::vec3(0.0f)}}, {});
  EXPECT_EQ(rays.FromSky(*MakeUniformSkyShape())[0], glm::vec3(0.0f));
}

TEST(TransportHardCases, RefusesWhatMakesNoSense) {
  const PatchScene scene = Yard();
  const PatchScene other = SceneOf({});
  const auto sky = MakeUniformSkyShape();
  EXPECT_THROW(PatchTransport(scene, {.rays_per_receiver = 0}), std::invalid_argument);
  const PatchTransport transport(scene, {.rays_per_receiver = 4});
  EXPECT_THROW(SolveSky(transport, other, *sky, 1), std::invalid_argument);
  EXPECT_THROW(SolveSky(transport, scene, *sky, -2), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(transport.SolveSun(scene, {0.0, 0.0, nan}, 0.005, 1), std::invalid_argument);
  EXPECT_THROW(transport.SolveSun(scene, {0.0, 0.0, 0.0}, 0.005, 1), std::invalid_argument);
  EXPECT_THROW(transport.SolveSun(scene, {0.0, 0.0, 1.0}, nan, 1), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::transport_hard_cases_test

#include "relight/transport/transport.h"

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/lighting.h"
#include "scene/sky_shape.h"
#include "scene/skyline.h"
#include "sunmodel/sky_shapes.h"
#include "tests/relight/probe_test_scenes.h"
#include "tests/relight/solve_sky.h"

namespace pleinair::transport_test {
namespace {

const glm::vec3 kUp(0.0f, 0.0f, 1.0f);

double AmbientWeight(const PatchScene& scene, const Receiver& receiver, int rays) {
  const GatheredRays gathered(scene, std::array{receiver}, {.rays_per_receiver = rays});
  return gathered.FromSky(*MakeUniformSkyShape())[0].x;
}

// Patches of `size_m` of a mesh with one albedo.
PatchScene Cut(Mesh mesh, double size_m, const glm::vec3& albedo) {
  mesh.materials.assign(1, {.name = "all", .diffuse_albedo = albedo});
  mesh.group_names = {"scene"};
  return BuildPatchScene(mesh,
                         {.patch_size_m = size_m, .growth_per_m = 0.0, .extend_ground = false});
}

// A bowl: the lower half of a sphere of 1 m, open at z = 0, normals inwards.
Mesh Bowl(int bands) {
  Mesh mesh;
  const int sectors = 4 * bands;
  const auto point = [&](int band, int sector) {
    const double down = 0.5 * std::numbers::pi * band / bands;
    const double azimuth = 2.0 * std::numbers::pi * (sector % sectors) / sectors;
    return glm::vec3(
        std::cos(down) * std::cos(azimuth), std::cos(down) * std::sin(azimuth), -std::sin(down));
  };
  for (int band = 0; band < bands; ++band) {
    for (int sector = 0; sector < sectors; ++sector) {
      AddQuad(mesh,
              point(band, sector),
              point(band, sector + 1),
              point(band + 1, sector + 1),
              point(band + 1, sector));
    }
  }
  // The quads at the lowest point have one side of no length; only their first triangle has area.
  return mesh;
}

TEST(GatheredRays, AReceiverInTheOpenSeesTheWholeSky) {
  const PatchScene nothing = SceneOf({});
  EXPECT_NEAR(AmbientWeight(nothing, {{0.0f, 0.0f, 0.0f}, kUp}, 256), 1.0, 1e-6);
}

// Half the cosine-weighted hemisphere of a wall is below the horizon. The lattice puts equal
// numbers of rays on either side but for the few at the border: 2 / sqrt(N) of them, at most.
TEST(GatheredRays, AnOpenWallSeesHalfOfIt) {
  const PatchScene nothing = SceneOf({});
  for (const glm::vec3& normal : {glm::vec3(1.0f, 0.0f, 0.0f), glm::vec3(0.6f, -0.8f, 0.0f)}) {
    EXPECT_NEAR(AmbientWeight(nothing, {{0.0f, 0.0f, 1.0f}, normal}, 1024), 0.5, 0.01);
  }
}

// A plane that looks down sees no sky, nor does a plane just over the ground.
TEST(GatheredRays, WhatLooksDownSeesNoSky) {
  Mesh mesh;
  AddGround(mesh, 60.0f);
  const PatchScene scene = SceneOf(std::move(mesh));
  EXPECT_EQ(AmbientWeight(scene, {{0.0f, 0.0f, 1.0f}, -kUp}, 256), 0.0);
  const GatheredRays rays(scene, std::array{Receiver{{0.0f, 0.0f, 1.0f}, -kUp}}, {});
  const std::vector<glm::vec3> glow(scene.FaceCount(), glm::vec3(2.0f));
  EXPECT_NEAR(rays.FromFaces(glow)[0].y, 2.0, 0.02);  // All but the rays over 60 m away.
}

// Four receivers at one place that share a set of directions see, together, what one with as many
// rays sees: a sky of two halves. 1e-6: rounding.
// A shape without a table, one with, and one that is partly hidden, together: each is the mean of
// its radiance over the rays.
TEST(GatheredRays, SkiesTogetherAreThoseAlone) {
  Mesh mesh;
  AddQuad(mesh, {-1.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 2.0f}, {-1.0f, 1.0f, 2.0f});
  const PatchScene scene = SceneOf(std::move(mesh));
  std::vector<float> hidden(SkyTable::kCells, 0.0f);
  std::vector<glm::vec3> table(SkyTable::kCells);
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    const glm::dvec3 direction = SkyTable::DirectionOfCell(cell);
    hidden[cell] = direction.z < 0.3 ? 0.5f : 0.0f;
    table[cell] = glm::vec3(1.0 + direction.x, 2.0 + direction.y, 1.0 + direction.z);
  }
  const auto shape = MakeTableSkyShape("slanted", std::move(table));
  const std::vector<glm::vec3> reflected(SkyTable::kCells, glm::vec3(0.0f));
  const auto partly = SeenPast(MakeSkyline(std::move(hidden), reflected), shape);
  const auto uniform = MakeUniformSkyShape();
  const std::vector<Receiver> receivers{{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}},
                                        {{0.0f, 0.5f, 1.0f}, {0.0f, 1.0f, 0.0f}}};
  GatherOptions options;
  options.rays_per_receiver = 512;
  const GatheredRays rays(scene, receivers, options);
  const SkyShape* const shapes[] = {uniform.get(), partly.get(), shape.get()};
  const std::vector<std::vector<glm::vec3>> together = rays.FromSkies(shapes);
  ASSERT_EQ(together.size(), 3u);
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    // Of the uniform sky there is the share of rays that reach it.
    EXPECT_LT(together[0][i].x, 0.95f);
    EXPECT_GT(together[0][i].x, 0.05f);
    for (std::size_t k = 0; k < 3; ++k) {
      glm::dvec3 sum(0.0);
      for (const glm::vec3& direction : rays.SkyDirectionsOf(i)) {
        sum += glm::dvec3(shapes[k]->Radiance(direction));
      }
      const glm::vec3 expected(std::numbers::pi / options.rays_per_receiver * sum);
      // To single precision of the table's sums.
      EXPECT_LT(glm::distance(together[k][i], expected), 1e-5f * glm::length(expected)) << k;
    }
  }
}

TEST(GatheredRays, ReceiversThatShareASetAreAsGoodAsOne) {
  Mesh wall;
  AddQuad(wall,
          {1.0f, -50.0f, -50.0f},
          {1.0f, -50.0f, 50.0f},
          {1.0f, 50.0f, 50.0f},
          {1.0f, 50.0f, -50.0f});
  const PatchScene scene = SceneOf(std::move(wall));
  const Receiver receiver{glm::vec3(0.0f), glm::normalize(glm::vec3(0.3f, 0.2f, 1.0f))};
  const std::vector<Receiver> same(4, receiver);
  const auto sky = MakeUniformSkyShape();
  const GatheredRays shared(scene, same, {.rays_per_receiver = 64, .receivers_per_set = 4});
  const GatheredRays one(scene, std::array{receiver}, {.rays_per_receiver = 256});
  float mean = 0.0f;
  for (const glm::vec3& irradiance : shared.FromSky(*sky)) mean += 0.25f * irradiance.x;
  EXPECT_NEAR(mean, one.FromSky(*sky)[0].x, 1e-6);
  EXPECT_LT(mean, 0.9f) << "the wall hides some";
  EXPECT_THROW(GatheredRays(scene, same, {.receivers_per_set = 0}), std::invalid_argument);
}

// Emission everywhere: B = e + rho B, the same on every face.
TEST(PatchTransport, AClosedRoomIsAFurnace) {
  Mesh mesh;
  AddBox(mesh, {0.0f, 0.0f, 0.0f}, {4.0f, 3.0f, 2.5f}, true);
  for (const float rho : {0.2f, 0.8f, 0.98f}) {
    const PatchScene scene = Cut(mesh, 1.0, glm::vec3(rho));
    const PatchTransport transport(scene, {.rays_per_receiver = 64});
    const std::vector<glm::vec3> emission(scene.FaceCount(), glm::vec3(1.0f / rho));
    const FaceLight light = transport.Solve(scene, emission, kAllBounces);
    EXPECT_LT(light.residual, 1e-5);
    for (std::size_t face = 0; face < scene.FaceCount(); face += 2) {
      // 1e-5 of what is missing plus float's rounding over some hundred iterations.
      EXPECT_NEAR(light.radiosity[face].x * (1.0f - rho), 1.0, 1e-4) << "albedo " << rho;
    }
  }
}

// Each point of a spherical bowl sees every other under the same form factor per area, so half of
// what it sees is the bowl and half the sky through the opening: c = 1/2 everywhere, and
// B = rho (1/2 + B/2) (the integrating sphere). Facets of 5.6 deg and 256 rays: 1 %.
TEST(PatchTransport, ABowlIsAnIntegratingSphere) {
  for (const float rho : {0.3f, 0.8f}) {
    const PatchScene scene = SceneOf(Bowl(16), glm::vec3(rho));
    const PatchTransport transport(scene, {.rays_per_receiver = 256});
    const auto sky = MakeUniformSkyShape();
    const std::vector<glm::vec3> direct = transport.DirectFromSky(*sky);
    const FaceLight all = SolveSky(transport, scene, *sky, kAllBounces);
    double mean_direct = 0.0;
    double mean_all = 0.0;
    double area = 0.0;
    for (std::size_t patch = 0; patch < scene.mesh.triangles.size(); ++patch) {
      const double a = scene.PatchAreaM2(patch);
      mean_direct += a * direct[2 * patch].x;
      mean_all += a * all.radiosity[2 * patch].x;
      area += a;
    }
    EXPECT_NEAR(mean_direct / area, 0.5, 0.005);
    EXPECT_NEAR(mean_all / area, rho * 0.5 / (1.0 - 0.5 * rho), 0.01 * rho);
  }
}

// Each light stops where it does when solved alone: the results are equal bit for bit.
TEST(PatchTransport, LightsSolvedTogetherAreThoseSolvedAlone) {
  const PatchScene scene = SceneOf(Bowl(8), glm::vec3(0.7f, 0.5f, 0.2f));
  const PatchTransport transport(scene, {.rays_per_receiver = 64});
  const glm::dvec3 sun = glm::normalize(glm::dvec3(0.3, 0.2, 0.9));
  const std::vector<std::shared_ptr<const SkyShape>> skies{MakeUniformSkyShape(),
                                                           MakeOvercastSkyShape()};
  for (const int bounces : {kAllBounces, 0, 1, 3}) {
    const std::vector<FaceLight> together = transport.SolveTogether(
        scene, skies, PatchTransport::Sun{sun, kMeanSunAngularRadiusRad}, bounces);
    ASSERT_EQ(together.size(), 3u);
    for (std::size_t k = 0; k < skies.size(); ++k) {
      EXPECT_EQ(together[k].radiosity, SolveSky(transport, scene, *skies[k], bounces).radiosity);
    }
    const FaceLight of_sun = transport.SolveSun(scene, sun, kMeanSunAngularRadiusRad, bounces);
    EXPECT_EQ(together[2].radiosity, of_sun.radiosity) << bounces;
    EXPECT_EQ(together[2].direct_irradiance, of_sun.direct_irradiance);
  }
  EXPECT_TRUE(transport.SolveTogether(scene, {}, std::nullopt, kAllBounces).empty());
}

// The same of facets that share patches, under the sky and an overhead sun, whose light through the
// opening, pi, falls on 2 pi. Some 90 patches of 256 rays and 6 points for the sun: 2 %.
TEST(PatchTransport, ABowlOfJoinedFacetsIsAnIntegratingSphere) {
  const float rho = 0.8f;
  const PatchScene scene = Cut(Bowl(32), 1.0, glm::vec3(rho));
  ASSERT_FALSE(scene.several.Empty());
  EXPECT_LT(20 * scene.PatchCount(), scene.mesh.triangles.size());
  const PatchTransport transport(scene, {.rays_per_receiver = 256});
  const auto sky = MakeUniformSkyShape();
  const std::vector<glm::vec3> direct = transport.DirectFromSky(*sky);
  const FaceLight all = SolveSky(transport, scene, *sky, kAllBounces);
  const std::vector<glm::vec3> of_sun =
      transport.DirectFromSun(scene, {0.0, 0.0, 1.0}, kMeanSunAngularRadiusRad);
  double mean_direct = 0.0;
  double mean_all = 0.0;
  double mean_of_sun = 0.0;
  double area = 0.0;
  for (std::size_t patch = 0; patch < scene.PatchCount(); ++patch) {
    const double a = scene.PatchAreaM2(patch);
    mean_direct += a * direct[2 * patch].x;
    mean_all += a * all.radiosity[2 * patch].x;
    mean_of_sun += a * of_sun[2 * patch].x;
    area += a;
    EXPECT_LT(of_sun[2 * patch + 1].x, 0.005f) << "the disc, from behind the rim";
  }
  EXPECT_NEAR(mean_direct / area, 0.5, 0.01);
  EXPECT_NEAR(mean_all / area, rho * 0.5 / (1.0 - 0.5 * rho), 0.02 * rho);
  EXPECT_NEAR(mean_of_sun / area, 0.5, 0.01);
}

TEST(PatchTransport, BouncesAreCountedAsReflectionsOnTheWay) {
  const PatchScene scene = SceneOf(Bowl(8), glm::vec3(0.5f));
  const PatchTransport transport(scene, {.rays_per_receiver = 64});
  const auto sky = MakeUniformSkyShape();
  const std::vector<glm::vec3> direct = transport.DirectFromSky(*sky);
  const FaceLight none = SolveSky(transport, scene, *sky, 0);
  const FaceLight one = SolveSky(transport, scene, *sky, 1);
  const FaceLight two = SolveSky(transport, scene, *sky, 2);
  const FaceLight all = SolveSky(transport, scene, *sky, kAllBounces);
  const FaceLight many = SolveSky(transport, scene, *sky, 40);
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    EXPECT_EQ(none.radiosity[face], glm::vec3(0.0f));
    EXPECT_EQ(one.radiosity[face], 0.5f * direct[face]);
    const glm::vec3 second =
        0.5f * (direct[face] + transport.FaceRays().FromFacesAt(face, one.radiosity));
    EXPECT_EQ(two.radiosity[face], second);
    EXPECT_NEAR(many.radiosity[face].x, all.radiosity[face].x, 1e-6);
  }
}

// Several rows are added up beside each other; each is the sum of its own entries in their order,
// however many rows there are and however long.
TEST(PatchTransport, EachFaceAddsUpItsOwnEntriesInTheirOrder) {
  const std::shared_ptr<const SkyShape> sky = MakeUniformSkyShape();
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    Mesh mesh = Bowl(8);
    const std::size_t count = mesh.triangles.size() - left_out;
    mesh.triangles.resize(count);
    mesh.triangle_material.resize(count);
    mesh.triangle_group.resize(count);
    const PatchScene scene = SceneOf(std::move(mesh), glm::vec3(0.5f));
    ASSERT_EQ(scene.FaceCount(), 2 * count);
    const PatchTransport transport(scene, {.rays_per_receiver = 64});
    const std::vector<glm::vec3> direct = transport.DirectFromSky(*sky);
    const FaceLight one = SolveSky(transport, scene, *sky, 1);
    const FaceLight two = SolveSky(transport, scene, *sky, 2);
    std::size_t lit = 0;
    for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
      const glm::vec3 from_faces = transport.FaceRays().FromFacesAt(face, one.radiosity);
      lit += from_faces != glm::vec3(0.0f) ? 1 : 0;
      EXPECT_EQ(two.radiosity[face], 0.5f * (direct[face] + from_faces)) << left_out;
    }
    EXPECT_GT(lit, count / 2);
    EXPECT_LT(lit, scene.FaceCount()) << "rows without entries are there, too";
  }
}

// Form factors of a unit cube's sides: 0.199825 opposite, 0.200044 adjacent (Hottel 1967).
TEST(PatchTransport, FormFactorsOfACubeAreThePublishedOnes) {
  Mesh mesh;
  AddBox(mesh, {0.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 1.0f}, true);
  const PatchScene scene = Cut(std::move(mesh), 0.4, glm::vec3(0.5f));
  const PatchTransport transport(scene, {.rays_per_receiver = 1024});
  const auto side_of = [&](std::size_t face) {
    return static_cast<std::size_t>(scene.source_triangle[face / 2] / 2);
  };
  std::array<std::array<double, 6>, 6> flow{};
  for (std::size_t face = 0; face < scene.FaceCount(); face += 2) {
    double row = 0.0;
    for (const auto& [other, share] : transport.FaceRays().FacesOf(face)) {
      EXPECT_EQ(other % 2, 0) << "the inside sees insides";
      flow[side_of(face)][side_of(static_cast<std::size_t>(other))] +=
          share * scene.PatchAreaM2(face / 2);
      row += share;
    }
    EXPECT_NEAR(row, 1.0, 1e-6);
  }
  // Down and up are 0 and 5. A side has 32 patches of 1024 rays: one standard error of as many
  // independent rays is 0.0022, and a lattice does better.
  EXPECT_NEAR(flow[0][5], 0.199825, 0.0022);
  EXPECT_NEAR(flow[0][1], 0.200044, 0.0022);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(flow[i][i], 0.0);
    for (std::size_t j = 0; j < i; ++j) EXPECT_NEAR(flow[i][j], flow[j][i], 0.0044);
  }
}

// A second method that shares nothing but the ray caster: paths with random bounces, everywhere
// pi * albedo at a time. 3 standard errors of the paths, plus 2 % for patches of constant
// radiosity.
TEST(PatchTransport, AgreesWithRandomPaths) {
  Mesh mesh;
  AddGround(mesh, 20.0f);
  AddBox(mesh, {2.0f, -4.0f, 0.0f}, {6.0f, 5.0f, 4.0f});
  AddBox(mesh, {-5.0f, -5.0f, 0.0f}, {-4.5f, 5.0f, 2.0f});
  const glm::vec3 albedo(0.6f, 0.4f, 0.2f);
  const PatchScene scene = Cut(std::move(mesh), 0.7, albedo);
  const glm::dvec3 sun = glm::normalize(glm::dvec3(-0.5, 0.3, 0.7));
  const PatchTransport transport(scene, {.rays_per_receiver = 128});
  const auto sky = MakeUniformSkyShape();
  const FaceLight sky_faces = SolveSky(transport, scene, *sky, kAllBounces);
  const FaceLight sun_faces = transport.SolveSun(scene, sun, 0.0, kAllBounces);
  const std::array<Receiver, 3> receivers{Receiver{{0.3f, 0.4f, 0.0f}, kUp},
                                          Receiver{{2.0f, 0.2f, 1.3f}, {-1.0f, 0.0f, 0.0f}},
                                          Receiver{{-4.5f, 1.0f, 0.6f}, {1.0f, 0.0f, 0.0f}}};
  const GatheredRays rays(scene, receivers, {.rays_per_receiver = 4096});
  const std::vector<glm::vec3> sky_direct = rays.FromSky(*sky);
  const std::vector<glm::vec3> sky_bounced = rays.FromFaces(sky_faces.radiosity);
  const std::vector<glm::vec3> sun_bounced = rays.FromFaces(sun_faces.radiosity);

  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto cosine_direction = [&](const glm::vec3& normal) {
    while (true) {  // The unit sphere about the normal's tip is cosine-distributed from its foot.
      const glm::dvec3 d(
          2.0 * unit(random) - 1.0, 2.0 * unit(random) - 1.0, 2.0 * unit(random) - 1.0);
      const double length = glm::length(d);
      if (length > 1.0 || length < 1e-3) continue;
      const glm::dvec3 sum = d / length + glm::dvec3(normal);
      if (glm::length(sum) > 1e-3) return glm::vec3(glm::normalize(sum));
    }
  };
  constexpr int kPaths = 10000;
  constexpr int kLongest = 30;
  for (std::size_t r = 0; r < receivers.size(); ++r) {
    glm::dvec3 sky_sum(0.0), sky_squares(0.0), sun_sum(0.0), sun_squares(0.0);
    for (int path = 0; path < kPaths; ++path) {
      glm::vec3 position = receivers[r].position_m;
      glm::vec3 normal = receivers[r].normal;
      glm::dvec3 weight(1.0), from_sky(0.0), from_sun(0.0);
      for (int bounce = 0; bounce < kLongest; ++bounce) {
        const glm::vec3 direction = cosine_direction(normal);
        const auto hit = scene.caster.Intersect(OffsetFromSurface(position, normal), direction);
        if (!hit) {
          if (direction.z > 0.0f) from_sky += weight;  // pi * (1 / pi).
          break;
        }
        position = hit->position_m;
        normal = glm::dot(hit->geometric_normal, direction) < 0.0f ? hit->geometric_normal
                                                                   : -hit->geometric_normal;
        weight *= glm::dvec3(albedo);
        const double cosine = glm::dot(glm::dvec3(normal), sun);
        if (cosine > 0.0 &&
            !scene.caster.Occluded(OffsetFromSurface(position, normal), glm::vec3(sun))) {
          from_sun += weight * cosine;
        }
      }
      sky_sum += from_sky;
      sky_squares += from_sky * from_sky;
      sun_sum += from_sun;
      sun_squares += from_sun * from_sun;
    }
    const auto expect_near = [&](const glm::vec3& ours, glm::dvec3 sum, glm::dvec3 squares) {
      for (int c = 0; c < 3; ++c) {
        const double mean = sum[c] / kPaths;
        const double error = std::sqrt((squares[c] / kPaths - mean * mean) / kPaths);
        EXPECT_NEAR(ours[c], mean, 3.0 * error + 0.02 * mean) << "receiver " << r;
      }
    };
    expect_near(sky_direct[r] + sky_bounced[r], sky_sum, sky_squares);
    expect_near(sun_bounced[r], sun_sum, sun_squares);
  }
}

TEST(PatchTransport, IsLinearInTheSky) {
  const PatchScene scene = SceneOf(Bowl(6), {0.5f, 0.3f, 0.7f});
  const PatchTransport transport(scene, {.rays_per_receiver = 32});
  std::vector<glm::vec3> a(scene.FaceCount()), b(a.size()), both(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] = glm::vec3(static_cast<float>(i % 7));
    b[i] = glm::vec3(1.0f, static_cast<float>(i % 3), 0.0f);
    both[i] = 2.0f * a[i] + 0.5f * b[i];
  }
  const FaceLight of_a = transport.Solve(scene, a, kAllBounces);
  const FaceLight of_b = transport.Solve(scene, b, kAllBounces);
  const FaceLight of_both = transport.Solve(scene, both, kAllBounces);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const glm::vec3 sum = 2.0f * of_a.radiosity[i] + 0.5f * of_b.radiosity[i];
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(of_both.radiosity[i][c], sum[c], 1e-5f * 20.0f);
  }
}

TEST(SunVisibility, FollowsTheDiscBehindAnEdge) {
  // A wall's upper edge at 45 deg as seen from the origin.
  Mesh mesh;
  AddQuad(mesh,
          {10.0f, -100.0f, -10.0f},
          {10.0f, 100.0f, -10.0f},
          {10.0f, 100.0f, 10.0f},
          {10.0f, -100.0f, 10.0f});
  const PatchScene scene = SceneOf(std::move(mesh));
  const Receiver receiver{{0.0f, 0.0f, 0.0f}, kUp};
  constexpr int kSamples = 256;
  for (double offset = -1.5; offset <= 1.5; offset += 0.1) {
    const double elevation = 0.25 * std::numbers::pi + offset * kMeanSunAngularRadiusRad;
    const glm::dvec3 sun(std::cos(elevation), 0.0, std::sin(elevation));
    const float seen =
        SunVisibility(scene.caster, receiver, sun, kMeanSunAngularRadiusRad, kSamples);
    const double x = std::clamp(offset, -1.0, 1.0);
    const double expected = 0.5 + (x * std::sqrt(1.0 - x * x) + std::asin(x)) / std::numbers::pi;
    // Where the centre and the four rim rays agree up to 9 % of the disc may be cut off.
    EXPECT_NEAR(seen, expected, 0.09 + 2.0 / std::sqrt(kSamples) * 0.1) << offset;
  }
}

}  // namespace
}  // namespace pleinair::transport_test

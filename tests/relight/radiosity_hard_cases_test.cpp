// Radiosity of closed rooms, of slivers, of one patch and of thousands, under one light and many.

#include <array>
#include <barrier>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "relight/transport/internal/region_irradiance.h"
#include "relight/transport/region_radiosity.h"
#include "tests/relight/window_room.h"

namespace pleinair::radiosity_hard_cases_test {
namespace {

constexpr GatherOptions kExposed{.rays_per_receiver = 256, .from_exposed_parts = true};

PatchScene ClosedRoom(double patch_size_m, float albedo) {
  Mesh mesh;
  AddBox(mesh, {0.0f, 0.0f, 0.0f}, {4.0f, 3.0f, 2.5f}, true);
  mesh.materials.assign(1, {.name = "all", .diffuse_albedo = glm::vec3(albedo)});
  mesh.group_names = {"room"};
  return CutRoom(mesh, patch_size_m);
}

SolveOptions Solve(int bounces = kAllBounces, double tolerance = 1e-6) {
  SolveOptions options;
  options.bounces = bounces;
  options.tolerance = tolerance;
  return options;
}

// Every emission settles at E / (1 - albedo), whatever the others are; 70 lights are three blocks,
// one of them not full. What is missing is 1e-6, what rounding adds over 700 iterations 1e-4.
TEST(RadiosityHardCases, AFurnaceOfManyLightsIsManyFurnaces) {
  constexpr std::size_t kLights = 70;
  for (const float albedo : {0.3f, 0.98f}) {
    const PatchScene scene = ClosedRoom(1.0, albedo);
    const PatchTransport transport(scene, {.rays_per_receiver = 64});
    std::vector<glm::vec3> emission(scene.FaceCount() * kLights);
    for (std::size_t i = 0; i < emission.size(); ++i) {
      emission[i] = glm::vec3(static_cast<float>(1 + i % kLights) / albedo);
    }
    const FaceLights lights = transport.SolveMany(scene, emission, kLights, Solve());
    EXPECT_LT(lights.residual, 1e-5);
    for (std::size_t face = 0; face < scene.FaceCount(); face += 2) {
      for (std::size_t light = 0; light < kLights; ++light) {
        const double expected = static_cast<double>(1 + light) / (1.0 - albedo);
        EXPECT_NEAR(lights.radiosity[face * kLights + light].y / expected, 1.0, 2e-4);
      }
    }
  }
}

// One wall alone is lit, in dark rooms and in such as hardly lose any light: far fewer sweeps than
// reflections lead to what 2000 reflections do. A face's sum is rounded by some 1e-6 of itself, of
// which all that is reflected since makes 1 / (1 - albedo) times as much.
TEST(RadiosityHardCases, LightOfOneWallComesToRestInFewSweeps) {
  struct Case {
    float albedo;
    int most_iterations;
  };
  for (const auto& [albedo, most_iterations] :
       {Case{0.0f, 3}, Case{0.3f, 12}, Case{0.7f, 25}, Case{0.95f, 80}, Case{0.98f, 120}}) {
    const PatchScene scene = ClosedRoom(1.0, albedo);
    const PatchTransport transport(scene, {.rays_per_receiver = 128});
    std::vector<glm::vec3> direct(scene.FaceCount(), glm::vec3(0.0f));
    for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
      if (scene.FaceNormal(face).x > 0.5f) direct[face] = glm::vec3(1.0f);
    }
    const FaceLight solved = transport.Solve(scene, direct, kAllBounces);
    const FaceLight exact = transport.Solve(scene, direct, 2000);
    EXPECT_LE(solved.iterations, most_iterations) << albedo;
    float largest = 0.0f;
    for (const glm::vec3& radiosity : exact.radiosity) largest = std::max(largest, radiosity.x);
    for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
      EXPECT_GE(solved.radiosity[face].x, 0.0f);
      EXPECT_NEAR(
          solved.radiosity[face].x, exact.radiosity[face].x, 2e-6f / (1.0f - albedo) * largest)
          << albedo;
    }
  }
}

TEST(RadiosityHardCases, ManyLightsAreWhatEachIsAlone) {
  const PatchScene scene = CutRoom(RoomWithWindow({0.7f, 0.5f, 0.2f}), 1.0);
  const PatchTransport transport(scene, kExposed);
  RegionRadiosityOptions options;
  options.sky_rays_per_patch = 1024;
  options.solve = Solve(4);
  const FaceLights all = SolveRegions(scene, transport, options);
  const std::vector<float> direct =
      internal::RegionIrradiance(scene,
                                 transport.Points(),
                                 {SkyRegions(), options.sky_rays_per_patch, options.seed},
                                 {0, scene.FaceCount()},
                                 {});
  for (const std::size_t light : {std::size_t{7}, std::size_t{40}}) {
    std::vector<glm::vec3> of_light;
    for (std::size_t i = light; i < direct.size(); i += 64) of_light.emplace_back(direct[i]);
    const FaceLight alone = transport.Solve(scene, of_light, 4);
    const std::vector<glm::vec3> of_all = all.OfLight(light);
    for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
      EXPECT_NEAR(of_all[face].x, alone.radiosity[face].x, 1e-6 * (1.0 + alone.radiosity[face].x));
    }
  }
}

// What side s of a room sends to side t by any number of bounces is what t would send to s: A_s E_s
// under an emission of t equals A_t E_t under one of s, where all albedos are one. 1 %: the noise
// of 512 rays from some 60 patches a side.
TEST(RadiosityHardCases, LightGoesBackTheWayItCame) {
  const PatchScene scene = ClosedRoom(0.6, 0.6f);
  GatherOptions gather;
  gather.rays_per_receiver = 512;
  const PatchTransport transport(scene, gather);
  constexpr std::size_t kSides = 6;
  const auto side_of = [&](std::size_t face) {
    const glm::vec3 n = scene.FaceNormal(face);
    return static_cast<std::size_t>((std::abs(n.x) > 0.5f   ? 0
                                     : std::abs(n.y) > 0.5f ? 2
                                                            : 4) +
                                    (n.x + n.y + n.z > 0 ? 1 : 0));
  };
  const float emitted = 1.0f / 0.6f;  // Emission / albedo.
  std::vector<glm::vec3> emission(scene.FaceCount() * kSides, glm::vec3(0.0f));
  for (std::size_t face = 0; face < scene.FaceCount(); face += 2) {
    emission[face * kSides + side_of(face)] = glm::vec3(emitted);
  }
  const FaceLights lights = transport.SolveMany(scene, emission, kSides, Solve());
  std::array<std::array<double, kSides>, kSides> flux{};  // [to][from].
  for (std::size_t face = 0; face < scene.FaceCount(); face += 2) {
    for (std::size_t from = 0; from < kSides; ++from) {
      const double own = side_of(face) == from ? 1.0 : 0.0;
      flux[side_of(face)][from] +=
          scene.PatchAreaM2(face / 2) * (lights.radiosity[face * kSides + from].y - own);
    }
  }
  for (std::size_t s = 0; s < kSides; ++s) {
    for (std::size_t t = 0; t < s; ++t) {
      EXPECT_GT(flux[s][t], 0.1);
      EXPECT_NEAR(flux[s][t] / flux[t][s], 1.0, 0.01) << s << " and " << t;
    }
  }
}

// Rows sum to 1 with the sky's share; what arrives is what was sent. Rays of a face leave it for
// the outside of a room through its window alone.
TEST(RadiosityHardCases, LightBetweenExposedFacesIsConserved) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.7f)), 0.8);
  const PatchTransport transport(scene, {.rays_per_receiver = 512, .from_exposed_parts = true});
  // Of the uniform sky there is the share of rays that reach it.
  const std::vector<glm::vec3> sky_share = transport.DirectFromSky(*MakeUniformSkyShape());
  std::size_t exposed = 0;
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    if (transport.Points().Of(face).empty()) continue;
    ++exposed;
    double sum = sky_share[face].x;
    for (const GatheredRays::FaceShare& share : transport.FaceRays().FacesOf(face)) {
      sum += share.share;
    }
    // What is missing looks below the horizon: there is no ground. Half of a wall's rays at most.
    EXPECT_LE(sum, 1.0 + 1e-5);
    EXPECT_GE(sum, scene.FaceNormal(face).z < -0.5f ? 0.0 : 0.45);
  }
  // Less than half of all faces: not those within the walls.
  EXPECT_LT(exposed, scene.FaceCount() / 2);
  EXPECT_GT(exposed, scene.FaceCount() / 4);
  RegionRadiosityOptions options;
  options.sky_rays_per_patch = 2048;
  const FaceLights lights = SolveRegions(scene, transport, options);
  // The worst of 64 lights: some of them come through the window as a narrow beam onto few patches.
  EXPECT_LT(lights.energy_error, 0.05);
}

// A floor that goes on under a wall is as bright at the wall as one that ends there.
TEST(RadiosityHardCases, WhatLiesUnderAWallTakesNoLight) {
  const auto floor_light = [](float beyond_m) {
    Mesh mesh;
    AddBox(
        mesh, {-3.0f - beyond_m, -3.0f - beyond_m, -0.2f}, {3.0f + beyond_m, 3.0f + beyond_m, 0});
    AddBox(mesh, {-3.5f, -3.5f, 0.0f}, {-3.0f, 3.5f, 2.0f});
    AddBox(mesh, {3.0f, -3.5f, 0.0f}, {3.5f, 3.5f, 2.0f});
    mesh.materials.assign(1, {.name = "all", .diffuse_albedo = glm::vec3(0.6f)});
    mesh.group_names = {"yard"};
    const PatchScene scene = CutRoom(mesh, 1.5);
    const PatchTransport transport(scene, {.rays_per_receiver = 512, .from_exposed_parts = true});
    RegionRadiosityOptions options;
    options.regions = SkyRegions(1, 1);
    options.sky_rays_per_patch = 16384;
    const FaceLights light = SolveRegions(scene, transport, options);
    const std::array at_wall{Receiver{{2.9f, 0.0f, 0.3f}, {0.0f, 0.0f, -1.0f}}};
    return GatheredRays(scene, at_wall, {.rays_per_receiver = 4096})
        .FromFaces(light.radiosity)[0]
        .x;
  };
  // 4 %: the patches' borders lie elsewhere. Counting the buried half would take a fifth away.
  EXPECT_NEAR(floor_light(0.45f) / floor_light(0.0f), 1.0, 0.04);
}

TEST(RadiosityHardCases, OneToTenThousandPatchesConverge) {
  Mesh one;
  AddQuad(one, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  one.triangles.pop_back();
  one.triangle_group.pop_back();
  one.triangle_material.pop_back();
  const PatchScene single = SceneOf(std::move(one), glm::vec3(0.25f));
  RegionRadiosityOptions options;
  options.sky_rays_per_patch = 1024;
  const PatchTransport of_single(single, kExposed);
  const FaceLights lights = SolveRegions(single, of_single, options);
  double sum = 0.0;
  for (std::size_t region = 0; region < 64; ++region) sum += lights.radiosity[region].x;
  EXPECT_NEAR(sum, 0.25 * std::numbers::pi, 0.005);
  for (std::size_t region = 0; region < 64; ++region) {
    EXPECT_EQ(lights.radiosity[64 + region], glm::vec3(0.0f));  // Its lower side.
  }

  const PatchScene many = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 0.4);
  ASSERT_GT(many.mesh.triangles.size(), 8000u);
  options.sky_rays_per_patch = 256;
  options.solve = Solve();
  const PatchTransport transport(many, {.rays_per_receiver = 64, .from_exposed_parts = true});
  const FaceLights solved = SolveRegions(many, transport, options);
  EXPECT_LT(solved.residual, 1e-4);
  for (const glm::vec3& radiosity : solved.radiosity) {
    ASSERT_TRUE(radiosity.x >= 0.0f && radiosity.x < 10.0f);
  }
}

// 10^4:1, side by side: an open plane, whose upper faces get the entire sky and no light from each
// other.
TEST(RadiosityHardCases, SliversAreAPlane) {
  Mesh mesh;
  for (int i = 0; i < 20; ++i) {
    const float y = 0.001f * static_cast<float>(i);
    AddQuad(mesh, {-5, y, 0}, {5, y, 0}, {5, y + 0.001f, 0}, {-5, y + 0.001f, 0});
  }
  const PatchScene scene = SceneOf(std::move(mesh));
  RegionRadiosityOptions options;
  options.regions = SkyRegions(1, 1);
  options.sky_rays_per_patch = 1024;
  const FaceLights light = SolveRegions(scene, PatchTransport(scene, kExposed), options);
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    EXPECT_NEAR(light.radiosity[face].x, face % 2 == 0 ? 0.5 * std::numbers::pi : 0.0, 0.005);
  }
}

TEST(RadiosityHardCases, SameBitsForAnyNumberOfThreads) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 1.5);
  const auto solve = [&] {
    RegionRadiosityOptions options;
    options.sky_rays_per_patch = 1024;
    return SolveRegions(scene, PatchTransport(scene, kExposed), options).radiosity;
  };
  const std::vector<glm::vec3> many = solve();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(solve(), many);
}

// Three ranks as three threads that hand each other their parts.
class ThreadRanks {
 public:
  explicit ThreadRanks(std::size_t count)
      : parts_(count), barrier_(static_cast<std::ptrdiff_t>(count)) {}

  class Member : public RankGroup {
   public:
    Member(ThreadRanks& group, std::size_t rank) : group_(group), rank_(rank) {}
    std::size_t Rank() const override { return rank_; }
    std::size_t Count() const override { return group_.parts_.size(); }
    std::vector<std::byte> Join(std::span<const std::byte> mine) override {
      group_.parts_[rank_].assign(mine.begin(), mine.end());
      group_.barrier_.arrive_and_wait();
      std::vector<std::byte> all;
      for (const auto& part : group_.parts_) all.insert(all.end(), part.begin(), part.end());
      group_.barrier_.arrive_and_wait();
      return all;
    }

   private:
    ThreadRanks& group_;
    std::size_t rank_;
  };

 private:
  std::vector<std::vector<std::byte>> parts_;
  std::barrier<> barrier_;
};

// 70 regions are three blocks of lights; four ranks leave one without any.
TEST(RadiosityHardCases, RanksShareTheWorkAndNotABitChanges) {
  const PatchScene scene = CutRoom(RoomWithWindow(glm::vec3(0.5f)), 1.5);
  const PatchTransport transport(scene, kExposed);
  RegionRadiosityOptions options;
  options.regions = SkyRegions(5, 14);
  options.sky_rays_per_patch = 1120;
  const FaceLights alone = SolveRegions(scene, transport, options);
  for (const std::size_t count : {1u, 4u}) {
    ThreadRanks ranks(count);
    std::vector<FaceLights> solved(count);
    std::vector<std::thread> threads;
    for (std::size_t rank = 0; rank < count; ++rank) {
      threads.emplace_back([&, rank] {
        ThreadRanks::Member member(ranks, rank);
        RegionRadiosityOptions shared = options;
        shared.ranks = &member;
        solved[rank] = SolveRegions(scene, transport, shared);
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const FaceLights& of_rank : solved) {
      EXPECT_EQ(of_rank.radiosity, alone.radiosity);
      EXPECT_EQ(of_rank.iterations, alone.iterations);
      EXPECT_EQ(of_rank.residual, alone.residual);
      EXPECT_EQ(of_rank.energy_error, alone.energy_error);
    }
  }
}

TEST(RadiosityHardCases, SaysItsMemoryAndRefusesWhatMakesNoSense) {
  EXPECT_LT(RadiosityBytes(10000, 500, {.rays_per_receiver = 512}, 16384), std::size_t{16} << 30);
  const PatchScene scene = ClosedRoom(4.0, 0.5f);
  const PatchTransport transport(scene, {.rays_per_receiver = 16});
  const std::vector<glm::vec3> direct(scene.FaceCount() * 2);
  EXPECT_THROW(transport.SolveMany(scene, direct, 3, Solve()), std::invalid_argument);
  EXPECT_THROW(transport.SolveMany(scene, {}, 0, Solve()), std::invalid_argument);
  EXPECT_THROW(transport.SolveMany(scene, direct, 2, Solve(-2)), std::invalid_argument);
  EXPECT_THROW(transport.SolveMany(scene, direct, 2, Solve(-1, 0.0)), std::invalid_argument);
  EXPECT_THROW(SolveRegions(scene, transport, RegionRadiosityOptions()),
               std::invalid_argument);  // Without points.
}

}  // namespace
}  // namespace pleinair::radiosity_hard_cases_test

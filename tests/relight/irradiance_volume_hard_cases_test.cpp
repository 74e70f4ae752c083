#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "relight/volume/irradiance_volume.h"
#include "relight/volume/vertex_irradiance.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair::irradiance_volume_hard_cases_test {
namespace {

const glm::vec3 kUp(0.0f, 0.0f, 1.0f);
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Probes that light a surface with irradiance 1, whatever its normal.
IrradianceVolume GrayVolume(const glm::ivec3& counts) {
  IrradianceVolume volume;
  volume.grid = {glm::vec3(0.0f), glm::vec3(1.0f, 0.5f, 2.0f), counts};
  ShRgb sh{};
  sh[0] = glm::vec3(1.0f / (std::sqrt(3.14159265f) * 0.5f));  // 1 / (A_0 Y_00)
  volume.probes.assign(volume.grid.ProbeCount(), sh);
  volume.valid.assign(volume.grid.ProbeCount(), 1);
  return volume;
}

void MarkInvalid(IrradianceVolume& volume, std::size_t probe) {
  volume.valid[probe] = 0;
  volume.probes[probe].fill(glm::vec3(kNan));  // Not even read.
}

TEST(IrradianceVolumeHardCases, InvalidProbesAreNeverRead) {
  IrradianceVolume volume = GrayVolume({3, 3, 3});
  for (const std::size_t probe : {0u, 4u, 13u, 14u, 22u, 26u}) MarkInvalid(volume, probe);
  for (float x = -0.5f; x < 2.6f; x += 0.25f) {
    for (float y = -0.5f; y < 1.6f; y += 0.125f) {
      for (float z = -1.0f; z < 5.0f; z += 0.5f) {
        EXPECT_NEAR(volume.Irradiance({x, y, z}, kUp).x, 1.0f, 1e-5f);
      }
    }
  }
}

TEST(IrradianceVolumeHardCases, TheNearestValidProbeStandsInForAWholeCell) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 200; ++trial) {
    IrradianceVolume volume = GrayVolume({5, 4, 6});
    for (std::size_t probe = 0; probe < volume.probes.size(); ++probe) {
      volume.probes[probe][0] *= static_cast<float>(probe + 1);  // To identify it.
      if (random() % 50 != 0) MarkInvalid(volume, probe);
    }
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    const glm::vec3 point =
        glm::vec3(6.0f, 4.0f, 14.0f) * glm::vec3(unit(random), unit(random), unit(random)) - 1.0f;
    // By brute force: the nearest one, or, in a cell that has a valid corner, no check.
    float best = std::numeric_limits<float>::infinity();
    std::size_t nearest = 0;
    const glm::vec3 clamped = glm::clamp(point, glm::vec3(0.0f), glm::vec3(4.0f, 1.5f, 10.0f));
    bool has_corner = false;
    for (std::size_t probe = 0; probe < volume.probes.size(); ++probe) {
      if (volume.valid[probe] == 0) continue;
      const glm::vec3 apart = volume.grid.PositionM(probe) - clamped;
      if (glm::dot(apart, apart) < best) {
        best = glm::dot(apart, apart);
        nearest = probe;
      }
      const glm::vec3 cells =
          glm::abs(volume.grid.PositionM(probe) - clamped) / volume.grid.spacing_m;
      has_corner = has_corner || glm::all(glm::lessThan(cells, glm::vec3(1.0f)));
    }
    const glm::vec3 got = volume.Irradiance(point, kUp);
    ASSERT_TRUE(std::isfinite(got.x));
    if (best == std::numeric_limits<float>::infinity()) {
      EXPECT_EQ(got, glm::vec3(0.0f));
    } else if (!has_corner) {
      EXPECT_NEAR(got.x, static_cast<float>(nearest + 1), 1e-4f) << trial;
    }
  }
}

TEST(IrradianceVolumeHardCases, NoValidProbeGivesNoLight) {
  IrradianceVolume volume = GrayVolume({2, 2, 2});
  for (std::size_t probe = 0; probe < 8; ++probe) MarkInvalid(volume, probe);
  EXPECT_EQ(volume.Irradiance({0.5f, 0.5f, 0.5f}, kUp), glm::vec3(0.0f));
}

TEST(IrradianceVolumeHardCases, OutsideTheGridItsBorderGoesOn) {
  IrradianceVolume volume = GrayVolume({2, 2, 2});
  for (std::size_t probe = 0; probe < 8; ++probe) {
    volume.probes[probe][0] *= static_cast<float>(probe + 1);
  }
  for (const float far : {2.0f, 1e3f, 1e30f}) {
    EXPECT_NEAR(volume.Irradiance({-far, -far, -far}, kUp).x, 1.0f, 1e-5f);
    EXPECT_NEAR(volume.Irradiance({far, far, 3.0f * far}, kUp).x, 8.0f, 1e-5f);
  }
}

TEST(IrradianceVolumeHardCases, GridsOfOneAndTwoProbesInterpolateAlongWhatTheyHave) {
  EXPECT_NEAR(GrayVolume({1, 1, 1}).Irradiance({5.0f, -3.0f, 0.2f}, kUp).x, 1.0f, 1e-6f);
  IrradianceVolume volume = GrayVolume({2, 1, 1});
  volume.probes[1][0] *= 3.0f;
  EXPECT_NEAR(volume.Irradiance({0.5f, 7.0f, -7.0f}, kUp).x, 2.0f, 1e-5f);
}

// A 10 cm wall stands square to x between probes 1 m apart, light on its far side only. A point at
// distance d before it takes at most 1 - d / h of what is beyond, and none from a cell away.
TEST(IrradianceVolumeHardCases, LightLeaksThroughAThinWallByNoMoreThanTheBound) {
  IrradianceVolume volume = GrayVolume({4, 2, 2});
  const float wall_m = 1.45f;
  for (std::size_t probe = 0; probe < volume.probes.size(); ++probe) {
    if (volume.grid.PositionM(probe).x < wall_m) volume.probes[probe] = ShRgb{};
  }
  for (float x = 0.0f; x < wall_m; x += 0.05f) {
    const float leaked = volume.Irradiance({x, 0.2f, 0.7f}, kUp).x;
    EXPECT_LE(leaked, std::max(0.0f, 1.0f - (wall_m - x) / 1.0f) + 1e-6f) << x;
    if (x < 1.0f) {
      EXPECT_EQ(leaked, 0.0f) << x;
    }
  }
}

// One bright lamp in three bands: the far side's lobes are negative, and are cut at 0.
TEST(IrradianceVolumeHardCases, NeverNegative) {
  IrradianceVolume volume = GrayVolume({1, 1, 1});
  const glm::vec3 lamp = glm::normalize(glm::vec3(0.3f, -0.5f, 0.8f));
  const auto basis = EvaluateShBasis9(lamp);
  for (std::size_t j = 0; j < basis.size(); ++j) volume.probes[0][j] = 1e4f * glm::vec3(basis[j]);
  int cut = 0;
  for (float azimuth = 0.0f; azimuth < 6.2f; azimuth += 0.1f) {
    for (float z = -1.0f; z <= 1.0f; z += 0.1f) {
      const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
      const glm::vec3 irradiance =
          volume.Irradiance(glm::vec3(0.0f), {r * std::cos(azimuth), r * std::sin(azimuth), z});
      ASSERT_GE(irradiance.x, 0.0f);
      if (irradiance.x == 0.0f) ++cut;
    }
  }
  EXPECT_GT(cut, 0);
}

// Grids with most, some and hardly any valid probes, flat ones too; boxes inside, across the border
// and outside. Marking all other probes as not valid changes no bit at any point of the boxes.
TEST(IrradianceVolumeHardCases, PointsInABoxNeedNoProbeButThoseNamed) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  int left_out = 0;
  for (int trial = 0; trial < 300; ++trial) {
    IrradianceVolume volume = GrayVolume(
        std::array{glm::ivec3(5, 4, 6), glm::ivec3(7, 1, 3), glm::ivec3(2, 9, 2)}[trial % 3]);
    const unsigned valid_of_50 = std::array{48u, 25u, 2u, 0u}[trial % 4];
    for (std::size_t probe = 0; probe < volume.probes.size(); ++probe) {
      volume.probes[probe][0] *= static_cast<float>(probe + 1);
      if (random() % 50 >= valid_of_50) MarkInvalid(volume, probe);
    }
    const auto random_point = [&] {
      return glm::vec3(10.0f, 8.0f, 16.0f) * glm::vec3(unit(random), unit(random), unit(random)) -
             2.0f;
    };
    std::vector<BoundingBox> boxes;
    for (int i = 0; i < 2; ++i) {
      const glm::vec3 lower = random_point();
      boxes.push_back({lower, glm::min(lower + 0.3f * (random_point() + 2.0f), glm::vec3(20.0f))});
    }
    const std::vector<std::uint8_t> needed = ProbesNeededIn(volume.grid, volume.valid, boxes);
    IrradianceVolume pruned = volume;
    for (std::size_t probe = 0; probe < needed.size(); ++probe) {
      if (needed[probe] != 0) continue;
      left_out += volume.valid[probe];
      MarkInvalid(pruned, probe);
    }
    for (int i = 0; i < 200; ++i) {
      const BoundingBox& box = boxes[static_cast<std::size_t>(i % 2)];
      glm::vec3 share(unit(random), unit(random), unit(random));
      if (i < 16) share = glm::vec3((i >> 1) & 1, (i >> 2) & 1, (i >> 3) & 1);
      const glm::vec3 point = glm::mix(box.lower_m, box.upper_m, share);
      ASSERT_EQ(pruned.Irradiance(point, kUp), volume.Irradiance(point, kUp)) << trial;
    }
  }
  EXPECT_GT(left_out, 1000);
}

TEST(IrradianceVolumeHardCases, CombinesTheNeededProbesAlone) {
  const PatchScene yard = Yard();
  const ProbeGrid grid = MakeProbeGrid({{-1, -1, 0}, {3, 1, 2}}, {9, 9, 9});
  const ProbeOperator probes(yard, nullptr, grid, {16, 1});
  const std::vector<glm::vec3> sky(probes.SkyDirections().size(), glm::vec3(0.3f));
  const BasisLights basis{
      std::vector<EnvironmentBasis>(2), std::vector<std::vector<glm::vec3>>(2), {{}, sky}};
  Lighting lighting;
  lighting.sky = {{"uniform", {100.0, 110.0, 120.0}}};
  const FoldedVolume folded(probes, basis);
  IrradianceVolume all, some;
  folded.Combine(lighting, {}, all);
  const std::array boxes{BoundingBox{{0.1f, 0.0f, 0.2f}, {0.6f, 0.3f, 0.9f}}};
  folded.Combine(lighting, ProbesNeededIn(grid, probes.Valid(), boxes), some);
  const glm::vec3 inside(0.3f, 0.2f, 0.5f);
  EXPECT_EQ(some.Irradiance(inside, kUp), all.Irradiance(inside, kUp));
  EXPECT_GT(all.Irradiance(inside, kUp).x, 0.0f);
  EXPECT_LT(std::count(some.valid.begin(), some.valid.end(), 1), 100);
  EXPECT_THROW(folded.Combine(lighting, std::vector<std::uint8_t>(3), some), std::invalid_argument);
  const std::array inside_out{BoundingBox{{1, 0, 0}, {0, 0, 0}}};
  EXPECT_THROW(ProbesNeededIn(grid, probes.Valid(), inside_out), std::invalid_argument);
}

TEST(IrradianceVolumeHardCases, SameBitsForAnyNumberOfThreads) {
  const PatchScene yard = Yard();
  const ProbeGrid grid = MakeProbeGrid({{-1, -1, 0}, {3, 1, 2}}, {20, 20, 20});
  const ProbeOperator probes(yard, nullptr, grid, {16, 1});
  const std::vector<glm::vec3> faces(yard.FaceCount(), glm::vec3(0.4f, 0.3f, 0.2f));
  const std::vector<glm::vec3> sky(probes.SkyDirections().size(), glm::vec3(0.3f));
  const BasisLights basis{std::vector<EnvironmentBasis>(2), {faces, faces}, {{}, sky}};
  Lighting lighting;
  lighting.sun.irradiance_rgb = {800.0, 700.0, 600.0};
  lighting.sky = {{"uniform", {100.0, 110.0, 120.0}}};
  std::vector<glm::vec3> positions(5000), normals(5000, kUp);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] = {0.0008f * static_cast<float>(i) - 1.0f, 0.3f, 0.9f};
  }
  std::vector<IrradianceVolume> volumes(3);
  std::vector<std::vector<glm::vec3>> irradiance(3, std::vector<glm::vec3>(positions.size()));
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t threads = std::array{1u, 2u, 8u}[i];
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    FoldedVolume(probes, basis).Combine(lighting, {}, volumes[i]);
    IrradianceAt(volumes[i], positions, normals, irradiance[i]);
  }
  EXPECT_EQ(volumes[0].probes, volumes[1].probes);
  EXPECT_EQ(volumes[0].probes, volumes[2].probes);
  EXPECT_EQ(irradiance[0], irradiance[1]);
  EXPECT_EQ(irradiance[0], irradiance[2]);
}

TEST(IrradianceVolumeHardCases, RefusesPointsThatAreNotNumbers) {
  const IrradianceVolume volume = GrayVolume({2, 2, 2});
  const std::vector<glm::vec3> positions{{0, 0, 0}, {0, kNan, 0}};
  const std::vector<glm::vec3> normals{kUp, kUp};
  std::vector<glm::vec3> irradiance(2);
  try {
    IrradianceAt(volume, positions, normals, irradiance);
    FAIL() << "took a position of NaN";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("positions_m[1]"));
  }
  EXPECT_THROW(volume.Irradiance({0, 0, 0}, {0, 0, kNan}), std::invalid_argument);
}

TEST(IrradianceVolumeHardCases, RefusesWhatDoesNotFit) {
  const IrradianceVolume volume = GrayVolume({2, 2, 2});
  const std::vector<glm::vec3> three(3, kUp);
  std::vector<glm::vec3> two(2);
  EXPECT_THROW(IrradianceAt(volume, three, two, two), std::invalid_argument);
  EXPECT_THROW(IrradianceAt(volume, three, three, two), std::invalid_argument);
  EXPECT_THROW(IrradianceVolume{}.Irradiance(kUp, kUp), std::invalid_argument);
  const VertexIrradiance points(volume, three, three);
  EXPECT_THROW(points.Evaluate(GrayVolume({3, 2, 2}), two), std::invalid_argument);

  const PatchScene yard = Yard();
  const ProbeOperator probes(yard, nullptr, {{0, 0, 1}, glm::vec3(1.0f), {1, 1, 1}}, {16, 1});
  BasisLights basis{std::vector<EnvironmentBasis>(2), std::vector<std::vector<glm::vec3>>(2), {}};
  EXPECT_THROW(FoldedVolume(probes, basis), std::invalid_argument);
  basis.sky_radiance.resize(2);
  FoldedVolume folded(probes, basis);
  IrradianceVolume out;
  EXPECT_THROW(folded.Combine(Lighting{}, {}, out), std::invalid_argument);
  EXPECT_THROW(FoldedVolume{}.Refold(probes, basis, 0), std::logic_error);
  EXPECT_THROW(FoldedVolume{}.Combine(Lighting{}, {}, out), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::irradiance_volume_hard_cases_test

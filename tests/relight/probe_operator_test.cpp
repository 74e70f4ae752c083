#include "relight/volume/probe_operator.h"

#include <cmath>
#include <numbers>
#include <sstream>

#include <gtest/gtest.h>
#include <cereal/archives/portable_binary.hpp>

#include "scene/sky_shape.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair::probe_operator_test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

ProbeGrid OneProbe(const glm::vec3& position_m) { return {position_m, glm::vec3(1.0f), {1, 1, 1}}; }

std::vector<glm::vec3> SkyRadiance(const ProbeOperator& probes, const SkyShape& shape) {
  std::vector<glm::vec3> radiance;
  for (const glm::vec3& direction : probes.SkyDirections()) {
    radiance.push_back(shape.Radiance(direction));
  }
  return radiance;
}

// Smooth and bright to one side, so that all coefficients have something to say.
glm::vec3 SlantedSky(const glm::vec3& direction) {
  return glm::vec3(1.0f + 0.5f * direction.x, 1.0f + direction.y * direction.z, direction.z);
}

// Root mean square over coefficients and channels.
double Rms(const ShRgb& sh) {
  double sum = 0.0;
  for (const glm::vec3& c : sh) sum += glm::dot(glm::dvec3(c), glm::dvec3(c));
  return std::sqrt(sum / (3.0 * kProbeShCoefficients));
}

ShRgb Minus(ShRgb a, const ShRgb& b) {
  for (std::size_t j = 0; j < a.size(); ++j) a[j] -= b[j];
  return a;
}

TEST(ProbeGrid, SpansTheBoxXFastest) {
  const ProbeGrid grid = MakeProbeGrid({{0.0f, 10.0f, -1.0f}, {2.0f, 13.0f, 1.0f}}, {3, 4, 2});
  ASSERT_EQ(grid.ProbeCount(), 24u);
  EXPECT_EQ(grid.PositionM(0), glm::vec3(0.0f, 10.0f, -1.0f));
  EXPECT_EQ(grid.PositionM(1), glm::vec3(1.0f, 10.0f, -1.0f));
  EXPECT_EQ(grid.PositionM(3), glm::vec3(0.0f, 11.0f, -1.0f));
  EXPECT_EQ(grid.PositionM(23), glm::vec3(2.0f, 13.0f, 1.0f));
}

TEST(ProbeGrid, ASingleProbeStandsInTheMiddle) {
  const ProbeGrid grid = MakeProbeGrid({{0.0f, 0.0f, 0.0f}, {2.0f, 4.0f, 6.0f}}, {1, 1, 1});
  EXPECT_EQ(grid.PositionM(0), glm::vec3(1.0f, 2.0f, 3.0f));
}

// L = 1/pi over the upper hemisphere: c00 = 2 pi Y00 / pi, c10 = Y1 (the integral of cos is pi),
// all others vanish. Heights are midpoints, exact for band 0 and 1; (2, 0) is off by 1 / N^2; of
// what turns with azimuth the last turn of the spiral above the horizon stays over, some 2 / N.
TEST(ProbeOperator, AnOpenUniformSkyHasItsClosedForm) {
  const PatchScene nothing = SceneOf({});
  const ProbeOperator probes(nothing, nullptr, OneProbe({0.0f, 0.0f, 2.0f}), {});
  const ShRgb sh = probes.Apply({}, {}, SkyRadiance(probes, *MakeUniformSkyShape()))[0];
  const float band0 = std::sqrt(1.0f / (4.0f * kPi));
  const float band1 = std::sqrt(3.0f / (4.0f * kPi));
  for (glm::length_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(sh[0][c], 2.0f * band0, 2e-6f);
    EXPECT_NEAR(sh[2][c], band1, 2e-6f);
    for (const std::size_t j : {1u, 3u, 4u, 5u, 6u, 7u, 8u}) EXPECT_NEAR(sh[j][c], 0.0f, 2e-3f);
  }
}

// The sphere is half sky, half ground of radiance 3 / pi, but for the 0.05 % of it between the
// ground's end at 2 km and the horizon below the probe at 1 m. (1, 0) is the difference of the two.
TEST(ProbeOperator, TheGroundIsTheOtherHalf) {
  Mesh mesh;
  AddGround(mesh, 2000.0f);
  const PatchScene plane = SceneOf(std::move(mesh));
  const ProbeOperator probes(plane, nullptr, OneProbe({0.3f, 0.2f, 1.0f}), {});
  const std::vector<glm::vec3> radiosity(plane.FaceCount(), glm::vec3(3.0f));
  const ShRgb sh = probes.Apply({}, radiosity, SkyRadiance(probes, *MakeUniformSkyShape()))[0];
  EXPECT_NEAR(sh[0].x, (1.0f + 3.0f) * 2.0f * std::sqrt(1.0f / (4.0f * kPi)), 0.003f);
  EXPECT_NEAR(sh[2].x, (1.0f - 3.0f) * std::sqrt(3.0f / (4.0f * kPi)), 0.003f);
}

// Furnace: the same radiance all around has no coefficient but the first, sqrt(4 pi).
TEST(ProbeOperator, AClosedRoomOfOneRadianceIsAFurnace) {
  Mesh mesh;
  AddBox(mesh, {-2.0f, -3.0f, 0.0f}, {4.0f, 2.0f, 3.0f}, /*inside_out=*/true);
  const PatchScene room = SceneOf(std::move(mesh));
  const ProbeOperator probes(room, nullptr, OneProbe({3.0f, -2.5f, 0.5f}), {});
  const std::vector<glm::vec3> radiosity(room.FaceCount(), glm::vec3(kPi));
  const ShRgb sh = probes.Apply({}, radiosity, {})[0];
  EXPECT_NEAR(sh[0].y, std::sqrt(4.0f * kPi), 1e-5f);
  for (std::size_t j = 1; j < sh.size(); ++j) EXPECT_NEAR(sh[j].y, 0.0f, 3e-3f);
}

// What the default number of rays costs in accuracy, beside a house: 1 % of the coefficients' rms.
// Found: 0.6 %.
TEST(ProbeOperator, TheDefaultRaysAreWithinOnePercentOfConverged) {
  const PatchScene yard = Yard();
  std::vector<glm::vec3> radiosity(yard.FaceCount());
  for (std::size_t face = 0; face < radiosity.size(); ++face) {
    radiosity[face] = glm::vec3(0.2f + 0.1f * static_cast<float>(face % 7));
  }
  const auto coefficients = [&](int rays) {
    const ProbeOperator probes(yard, nullptr, OneProbe({2.0f, 1.0f, 1.0f}), {rays, 1});
    std::vector<glm::vec3> sky;
    for (const glm::vec3& direction : probes.SkyDirections()) sky.push_back(SlantedSky(direction));
    return probes.Apply({}, radiosity, sky)[0];
  };
  const ShRgb converged = coefficients(1 << 18);
  const double error = Rms(Minus(coefficients(ProbeOptions{}.rays_per_probe), converged));
  EXPECT_LT(error, 0.01 * Rms(converged));
  RecordProperty("relative_rms_error", std::to_string(error / Rms(converged)));
}

TEST(ProbeOperator, AnotherSeedTurnsTheRaysButNotTheAnswer) {
  const PatchScene yard = Yard();
  const std::vector<glm::vec3> radiosity(yard.FaceCount(), glm::vec3(0.7f));
  const auto coefficients = [&](std::uint64_t seed) {
    const ProbeOperator probes(yard, nullptr, OneProbe({2.0f, 1.0f, 1.0f}), {1024, seed});
    return probes.Apply({}, radiosity, SkyRadiance(probes, *MakeUniformSkyShape()))[0];
  };
  const ShRgb one = coefficients(1);
  const double apart = Rms(Minus(coefficients(2), one));
  EXPECT_GT(apart, 0.0);
  EXPECT_LT(apart, 0.02 * Rms(one));  // Each within 1 %, see above.
}

// How much of band 0, which weights all directions equally, comes from each of the three sources.
struct Shares {
  float map = 0.0f;
  float faces = 0.0f;
  float sky = 0.0f;
};

Shares SharesOf(const ProbeOperator& probes, std::size_t pixels, std::size_t faces) {
  const std::vector<glm::vec3> map(pixels, glm::vec3(1.0f));
  const std::vector<glm::vec3> radiosity(faces, glm::vec3(kPi));
  const std::vector<glm::vec3> sky(probes.SkyDirections().size(), glm::vec3(1.0f));
  const float all = std::sqrt(4.0f * kPi);
  return {probes.Apply(map, {}, {})[0][0].x / all,
          probes.Apply({}, radiosity, {})[0][0].x / all,
          probes.Apply({}, {}, sky)[0][0].x / all};
}

// From where the map was taken all is in it, but for texels that an edge crosses and the last
// metres of ground before the horizon, where a texel is stretched beyond its use.
TEST(ProbeOperator, WhereTheMapWasTakenAllIsTakenFromIt) {
  const PatchScene yard = Yard();
  const Survey survey = SurveyOf(yard, {0.0, 0.0, 1.5}, {256, 128}, {0.0, 0.0, 1.0});
  const ProbeOperator probes(yard, &survey, OneProbe({0.0f, 0.0f, 1.5f}), {});
  const Shares shares = SharesOf(probes, 256 * 128, yard.FaceCount());
  EXPECT_GT(shares.map, 0.95f);
  EXPECT_LT(shares.sky, 0.01f);
}

// Behind the house, seen from the map, lies only what the map does not see: its rear and the ground
// in its shade. The sky is in the map, but for the part that the house hides from it.
TEST(ProbeOperator, WhatTheMapCannotSeeIsTakenFromThePatches) {
  const PatchScene yard = Yard();
  const Survey survey = SurveyOf(yard, {0.0, 0.0, 1.5}, {256, 128}, {0.0, 0.0, 1.0});
  const glm::vec3 behind(9.5f, 0.0f, 0.5f);
  const ProbeOperator probes(yard, &survey, OneProbe(behind), {});
  const Shares shares = SharesOf(probes, 256 * 128, yard.FaceCount());
  // The rear wall fills nearly half of the view, the shaded ground most of what is below.
  EXPECT_GT(shares.faces, 0.6f);
  EXPECT_GT(shares.map, 0.1f);
  const ProbeOperator without(yard, nullptr, OneProbe(behind), {});
  const Shares all = SharesOf(without, 0, yard.FaceCount());
  EXPECT_NEAR(shares.map + shares.faces + shares.sky, all.faces + all.sky, 1e-6f);
}

// The map's neighbour in the picture stands at another depth: a probe before a wall must not take
// the wall's light from pixels that show the house in front of it.
TEST(ProbeOperator, TakesNoPixelOfAnotherSurfaceInTheSameDirection) {
  Mesh mesh;
  AddQuad(mesh, {5, -20, -5}, {5, -20, 15}, {5, 20, 15}, {5, 20, -5});  // Faces west, far.
  AddQuad(mesh, {3, -20, -5}, {3, -20, 15}, {3, 20, 15}, {3, 20, -5});  // Faces west, near.
  const PatchScene walls = SceneOf(std::move(mesh));
  const Survey survey = SurveyOf(walls, {0.0, 0.0, 1.5}, {128, 64}, {0.0, 0.0, 1.0});
  const ProbeOperator probes(walls, &survey, OneProbe({4.0f, 0.0f, 1.5f}), {});
  const Shares shares = SharesOf(probes, 128 * 64, walls.FaceCount());
  EXPECT_GT(shares.faces, 0.75f);  // Both walls, each nearly a half; the map shows neither.
  EXPECT_LT(shares.map, 0.1f);     // Sky between the walls.
}

TEST(ProbeOperator, PixelsWithoutAMeasuredAlbedoGiveWayToThePatch) {
  const PatchScene yard = Yard();
  Survey survey = SurveyOf(yard, {0.0, 0.0, 1.5}, {128, 64}, {0.0, 0.0, 1.0});
  survey.view.albedo_measured = Image<std::uint8_t>(128, 64, 0);
  const ProbeOperator probes(yard, &survey, OneProbe({0.0f, 0.0f, 1.5f}), {});
  const ProbeOperator without(yard, nullptr, OneProbe({0.0f, 0.0f, 1.5f}), {});
  EXPECT_EQ(SharesOf(probes, 128 * 64, yard.FaceCount()).faces,
            SharesOf(without, 0, yard.FaceCount()).faces);
}

TEST(ProbeOperator, ComesBackFromBytesAsItWas) {
  const PatchScene yard = Yard();
  const ProbeGrid grid = MakeProbeGrid({{-1.0f, -1.0f, 0.0f}, {4.0f, 1.0f, 2.0f}}, {3, 2, 2});
  const ProbeOperator made(yard, nullptr, grid, {64, 7});
  std::stringstream bytes;
  cereal::PortableBinaryOutputArchive{bytes}(made);
  ProbeOperator back;
  cereal::PortableBinaryInputArchive{bytes}(back);
  EXPECT_EQ(back.Grid().counts, grid.counts);
  EXPECT_EQ(back.Valid(), made.Valid());
  EXPECT_EQ(back.SkyDirections(), made.SkyDirections());
  const std::vector<glm::vec3> radiosity(yard.FaceCount(), glm::vec3(0.3f));
  EXPECT_EQ(back.Apply({}, radiosity, {}), made.Apply({}, radiosity, {}));
}

}  // namespace
}  // namespace pleinair::probe_operator_test

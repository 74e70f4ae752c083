#include <algorithm>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <cereal/archives/binary.hpp>

#include "relight/volume/probe_operator.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair::probe_operator_hard_cases_test {
namespace {

ProbeGrid OneProbe(const glm::vec3& position_m) { return {position_m, glm::vec3(1.0f), {1, 1, 1}}; }

bool ValidAt(const PatchScene& scene, const glm::vec3& position_m) {
  return ProbeOperator(scene, nullptr, OneProbe(position_m), {256, 1}).Valid()[0] != 0;
}

// Share of directions from which a probe gets light when all surfaces shine, and when the sky does.
glm::vec2 FaceAndSkyShare(const PatchScene& scene, const glm::vec3& position_m) {
  const ProbeOperator probes(scene, nullptr, OneProbe(position_m), {256, 1});
  const std::vector<glm::vec3> faces(scene.FaceCount(), glm::vec3(3.14159265f));
  const std::vector<glm::vec3> sky(probes.SkyDirections().size(), glm::vec3(1.0f));
  const float all = std::sqrt(4.0f * 3.14159265f);
  return {probes.Apply({}, faces, {})[0][0].x / all, probes.Apply({}, {}, sky)[0][0].x / all};
}

TEST(ProbeOperatorHardCases, AProbeInAWallIsMarkedAndDark) {
  const PatchScene yard = Yard();
  EXPECT_FALSE(ValidAt(yard, {5.0f, 0.0f, 3.0f}));    // In the house.
  EXPECT_FALSE(ValidAt(yard, {-7.75f, 0.0f, 1.0f}));  // In the low wall.
  EXPECT_FALSE(ValidAt(yard, {0.0f, 0.0f, -0.5f}));   // Under the ground.
  EXPECT_TRUE(ValidAt(yard, {0.0f, 0.0f, 1.0f}));
  EXPECT_TRUE(ValidAt(yard, {-7.0f, 0.0f, 0.1f}));  // In the corner of wall and ground.
  EXPECT_EQ(FaceAndSkyShare(yard, {5.0f, 0.0f, 3.0f}), glm::vec2(0.0f));
}

// On a surface it sees what a probe just in front of it sees: half sky, half ground.
TEST(ProbeOperatorHardCases, AProbeOnTheGroundStandsOnIt) {
  for (const bool upside_down : {false, true}) {
    Mesh mesh;
    AddGround(mesh, 500.0f);
    if (upside_down) {
      for (glm::uvec3& triangle : mesh.triangles) std::swap(triangle.y, triangle.z);
    }
    const PatchScene plane = SceneOf(std::move(mesh));
    for (const glm::vec3& position : {glm::vec3(0.0f), glm::vec3(17.3f, -4.1f, 0.0f)}) {
      EXPECT_TRUE(ValidAt(plane, position));
      const glm::vec2 shares = FaceAndSkyShare(plane, position);
      EXPECT_NEAR(shares.x, 0.5f, 0.005f) << "upside down: " << upside_down;
      EXPECT_NEAR(shares.y, 0.5f, 0.005f);
    }
  }
}

// On the house's wall: sky and surfaces share the outer half, the wall fills the other one.
TEST(ProbeOperatorHardCases, AProbeOnAWallOrInACornerStandsOutside) {
  const PatchScene yard = Yard();
  const glm::vec2 on_wall = FaceAndSkyShare(yard, {3.0f, 0.5f, 3.0f});
  EXPECT_NEAR(on_wall.x, 0.75f, 0.05f);
  EXPECT_NEAR(on_wall.y, 0.25f, 0.05f);
  const glm::vec2 in_corner = FaceAndSkyShare(yard, {3.0f, 0.5f, 0.0f});
  EXPECT_NEAR(in_corner.y, 0.25f, 0.05f);
  EXPECT_NEAR(in_corner.x + in_corner.y, 1.0f, 0.02f);
}

// On two coincident sheets wound against each other, as modellers export two-sided walls.
TEST(ProbeOperatorHardCases, AProbeOnADoubledSheetStandsOnOneSideOfIt) {
  Mesh mesh;
  AddGround(mesh, 500.0f);
  AddGround(mesh, 500.0f);
  for (std::size_t i = 2; i < 4; ++i) std::swap(mesh.triangles[i].y, mesh.triangles[i].z);
  const PatchScene plane = SceneOf(std::move(mesh));
  EXPECT_TRUE(ValidAt(plane, glm::vec3(0.0f)));
  EXPECT_NEAR(FaceAndSkyShare(plane, glm::vec3(0.0f)).y, 0.5f, 0.005f);
}

// A room drawn as one sheet wound outwards looks like the inside of a solid, but for its skylight:
// the probes under it see the sky, and those in the far corners see them.
TEST(ProbeOperatorHardCases, ARoomWoundOutwardsStaysUsableThroughItsOpening) {
  Mesh mesh;
  AddBox(mesh, {0.0f, 0.0f, 0.0f}, {6.0f, 6.0f, 3.0f}, /*inside_out=*/false, /*with_top=*/false);
  AddQuad(mesh, {0, 0, 3}, {4, 0, 3}, {4, 6, 3}, {0, 6, 3});  // The roof ends at x = 4.
  const PatchScene room = SceneOf(std::move(mesh));
  const ProbeGrid grid = MakeProbeGrid({{0.3f, 0.3f, 0.3f}, {5.7f, 5.7f, 2.7f}}, {4, 4, 3});
  const ProbeOperator probes(room, nullptr, grid, {256, 1});
  EXPECT_EQ(std::count(probes.Valid().begin(), probes.Valid().end(), 1), 48);
}

// Neighbours on both sides of a solid wall: the free ones must not lead the way into it.
TEST(ProbeOperatorHardCases, AGridThroughAWallLosesJustTheProbesInIt) {
  Mesh mesh;
  AddGround(mesh, 50.0f);
  AddBox(mesh, {0.9f, -10.0f, -1.0f}, {1.1f, 10.0f, 8.0f});
  const PatchScene scene = SceneOf(std::move(mesh));
  const ProbeGrid grid{{0.0f, 0.0f, -0.5f}, glm::vec3(0.5f), {5, 3, 4}};
  const ProbeOperator probes(scene, nullptr, grid, {256, 1});
  for (std::size_t i = 0; i < grid.ProbeCount(); ++i) {
    const glm::vec3 position = grid.PositionM(i);
    const bool free = position.z > -0.1f && std::abs(position.x - 1.0f) > 0.1f;
    EXPECT_EQ(probes.Valid()[i] != 0, free) << position.x << " " << position.y << " " << position.z;
  }
}

TEST(ProbeOperatorHardCases, SmallLongAndLargeGridsWork) {
  const PatchScene yard = Yard();
  const BoundingBox box{{-2.0f, -2.0f, 0.2f}, {2.0f, 2.0f, 2.2f}};
  for (const glm::ivec3& counts : {glm::ivec3(1), glm::ivec3(2, 1, 1), glm::ivec3(64)}) {
    const ProbeOperator probes(yard, nullptr, MakeProbeGrid(box, counts), {8, 1});
    const std::size_t expected = static_cast<std::size_t>(counts.x * counts.y * counts.z);
    ASSERT_EQ(probes.Valid().size(), expected);
    EXPECT_EQ(std::count(probes.Valid().begin(), probes.Valid().end(), 1),
              static_cast<std::ptrdiff_t>(expected));
    EXPECT_EQ(probes.Apply({}, {}, {}).size(), expected);
  }
}

TEST(ProbeOperatorHardCases, AFlatBoxGetsOneLayer) {
  const ProbeGrid grid = MakeProbeGrid({{0.0f, 0.0f, 1.0f}, {2.0f, 2.0f, 1.0f}}, {3, 3, 8});
  EXPECT_EQ(grid.counts, glm::ivec3(3, 3, 1));
  EXPECT_EQ(grid.PositionM(8), glm::vec3(2.0f, 2.0f, 1.0f));
}

TEST(ProbeOperatorHardCases, SameBitsForAnyNumberOfThreads) {
  const PatchScene yard = Yard();
  const Survey survey = SurveyOf(yard, {0.0, 0.0, 1.5}, {64, 32}, {0.0, 0.0, 1.0});
  const ProbeGrid grid = MakeProbeGrid({{-1.0f, -1.0f, 0.0f}, {4.0f, 1.0f, 2.0f}}, {6, 3, 3});
  const std::vector<glm::vec3> map(64 * 32, glm::vec3(0.3f, 0.2f, 0.1f));
  const std::vector<glm::vec3> faces(yard.FaceCount(), glm::vec3(0.7f));
  std::vector<std::string> bytes;
  std::vector<std::vector<ShRgb>> coefficients;
  for (const std::size_t threads : {1u, 2u, 8u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const ProbeOperator probes(yard, &survey, grid, {256, 1});
    std::ostringstream stream;
    cereal::BinaryOutputArchive{stream}(probes);
    bytes.push_back(stream.str());
    coefficients.push_back(probes.Apply(map, faces, {}));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_EQ(bytes[0], bytes[2]);
  EXPECT_EQ(coefficients[0], coefficients[1]);
  EXPECT_EQ(coefficients[0], coefficients[2]);
}

TEST(ProbeOperatorHardCases, RefusesBytesThatAreNoOperator) {
  const ProbeOperator probes(Yard(), nullptr, OneProbe({0.0f, 0.0f, 1.0f}), {16, 1});
  std::ostringstream stream;
  cereal::BinaryOutputArchive{stream}(probes);
  const std::string whole = stream.str();
  const auto load = [](const std::string& bytes) {
    std::istringstream in(bytes);
    ProbeOperator back;
    cereal::BinaryInputArchive{in}(back);
  };
  EXPECT_NO_THROW(load(whole));
  EXPECT_ANY_THROW(load(whole.substr(0, whole.size() / 2)));
  std::string wrong_source = whole;
  wrong_source[whole.size() - 2] = '\x7f';  // An index far beyond the faces.
  EXPECT_THROW(load(wrong_source), std::runtime_error);
}

TEST(ProbeOperatorHardCases, RefusesGridsAndOptionsThatMakeNoSense) {
  const PatchScene yard = Yard();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const ProbeGrid good = OneProbe({0.0f, 0.0f, 1.0f});
  ProbeGrid grid = good;
  grid.counts.y = 0;
  EXPECT_THROW(ProbeOperator(yard, nullptr, grid, {}), std::invalid_argument);
  grid = good;
  grid.spacing_m.x = 0.0f;
  EXPECT_THROW(ProbeOperator(yard, nullptr, grid, {}), std::invalid_argument);
  grid = good;
  grid.lower_m.z = nan;
  EXPECT_THROW(ProbeOperator(yard, nullptr, grid, {}), std::invalid_argument);
  EXPECT_THROW(ProbeOperator(yard, nullptr, good, {0, 1}), std::invalid_argument);
  EXPECT_THROW(MakeProbeGrid({{0, 0, 0}, {1, -1, 1}}, {2, 2, 2}), std::invalid_argument);
  EXPECT_THROW(MakeProbeGrid({{0, 0, 0}, {1, nan, 1}}, {2, 2, 2}), std::invalid_argument);
  EXPECT_THROW(MakeProbeGrid({{0, 0, 0}, {1, 1, 1}}, {2, 0, 2}), std::invalid_argument);
}

TEST(ProbeOperatorHardCases, RefusesLightThatDoesNotFit) {
  const PatchScene yard = Yard();
  const ProbeOperator probes(yard, nullptr, OneProbe({0.0f, 0.0f, 1.0f}), {16, 1});
  const std::vector<glm::vec3> three(3);
  EXPECT_THROW(probes.Apply(three, {}, {}), std::invalid_argument);
  EXPECT_THROW(probes.Apply({}, three, {}), std::invalid_argument);
  EXPECT_THROW(probes.Apply({}, {}, three), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::probe_operator_hard_cases_test

#include "scene/skyline.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "scene/lat_long.h"
#include "tests/scene/irradiance_by_points.h"

namespace pleinair::skyline_test {
namespace {

using testing::IrradianceByPoints;

constexpr float kTopZ = 0.5f;  // 30 deg.
const glm::vec3 kReflected(0.02f, 0.03f, 0.01f);

// All around, from the horizon up.
Skyline Ring() {
  std::vector<float> hidden(SkyTable::kCells, 0.0f);
  std::vector<glm::vec3> reflected(SkyTable::kCells, glm::vec3(0.0f));
  for (std::size_t cell = 0; cell < SkyTable::kCells; ++cell) {
    if (SkyTable::DirectionOfCell(cell).z > kTopZ) continue;
    hidden[cell] = 1.0f;
    reflected[cell] = kReflected;
  }
  return MakeSkyline(std::move(hidden), std::move(reflected));
}

// An even sky brings 1 - sin^2(30 deg) over the ring, which brings pi sin^2(30 deg) times its
// radiance. 1e-2: the ring's edge is as wide as a cell, 2 cos(30 deg) 0.45 deg of irradiance.
TEST(Skyline, TakesAwayWhatItHidesAndAddsWhatItReflects) {
  const auto shape = SeenPast(Ring(), MakeUniformSkyShape());
  const glm::dvec3 irradiance = IrradianceByPoints(*shape, 20000);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(irradiance[c], 0.75 + 0.25 * std::numbers::pi * kReflected[c], 1e-2);
  }
  EXPECT_EQ(shape->Name(), "uniform");
  EXPECT_FLOAT_EQ(shape->Radiance({0.0f, 0.0f, 1.0f}).x, std::numbers::inv_pi_v<float>);
  EXPECT_EQ(shape->Radiance({0.96f, 0.0f, 0.28f}), kReflected);
  EXPECT_EQ(shape->Radiance({0.96f, 0.0f, -0.28f}), glm::vec3(0.0f));
}

TEST(Skyline, IsLookedPastInATableAsInAFunction) {
  std::vector<glm::vec3> table(SkyTable::kCells);
  for (std::size_t cell = 0; cell < table.size(); ++cell) {
    table[cell] = glm::vec3(glm::dvec3(1.0 + SkyTable::DirectionOfCell(cell).y));
  }
  const auto bare = MakeTableSkyShape("table", table);
  const auto seen = SeenPast(Ring(), bare);
  for (const glm::vec3& high : {glm::vec3(0.6f, 0.0f, 0.8f), glm::vec3(0.0f, -0.6f, 0.8f)}) {
    EXPECT_EQ(seen->Radiance(high), bare->Radiance(high));
  }
  EXPECT_EQ(seen->Radiance({0.0f, -0.96f, 0.28f}), kReflected);
}

TEST(Skyline, LeavesTheShapeItselfWhereNothingHidesTheSky) {
  const auto shape = MakeUniformSkyShape();
  EXPECT_EQ(SeenPast({}, shape), shape);
}

// pi sin^2(30 deg) from above, half of that for a wall less the part over 30 deg:
// pi / 2 - (pi / 3 - sin(60 deg) / 2), none from below.
TEST(Skyline, KnowsWhatItHidesFromEachNormal) {
  const RgbImage irradiance = Ring().irradiance_of_hidden;
  const double above_30_deg = std::numbers::pi / 3.0 - 0.5 * std::sin(std::numbers::pi / 3.0);
  EXPECT_NEAR(SampleLatLong(irradiance, {0.0, 0.0, 1.0}).x, 0.25 * std::numbers::pi, 0.02);
  EXPECT_NEAR(
      SampleLatLong(irradiance, {1.0, 0.0, 0.0}).y, 0.5 * std::numbers::pi - above_30_deg, 0.02);
  EXPECT_LT(SampleLatLong(irradiance, {0.0, 0.0, -1.0}).z, 0.02);
}

TEST(Skyline, OfOtherCellsIsRefused) {
  EXPECT_THROW(MakeSkyline(std::vector<float>(7), std::vector<glm::vec3>(SkyTable::kCells)),
               std::invalid_argument);
  EXPECT_TRUE(
      MakeSkyline(std::vector<float>(SkyTable::kCells), std::vector<glm::vec3>(SkyTable::kCells))
          .Empty());
}

}  // namespace
}  // namespace pleinair::skyline_test

#include "pipeline/shadow_edge_marks.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "sunmodel/angles.h"
#include "sunmodel/north.h"

namespace pleinair::shadow_edge_marks_test {
namespace {

constexpr double kWallHeightM = 4.0;

void AddQuad(Mesh& mesh, const std::vector<glm::vec3>& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  mesh.positions_m.insert(mesh.positions_m.end(), corners.begin(), corners.end());
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

// Ground, and a wall of two parts: its top determines elevation, its ends azimuth.
Mesh GroundAndWall() {
  Mesh mesh;
  AddQuad(mesh, {{-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0}});
  AddQuad(mesh, {{-3, 0, 0}, {3, 0, 0}, {3, 0, kWallHeightM}, {-3, 0, kWallHeightM}});
  return mesh;
}

glm::dvec3 Sun(double azimuth_deg, double elevation_deg) {
  const double a = RadFromDeg(azimuth_deg);
  const double e = RadFromDeg(elevation_deg);
  return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

// 20 m above the ground, looking straight down; up in the picture is north.
Camera LookingDown() {
  Camera camera;
  camera.intrinsics = {800, 600, 500.0, 500.0, 399.5, 299.5, {}};
  camera.camera_from_world = glm::dmat4(glm::dvec4(1, 0, 0, 0),
                                        glm::dvec4(0, -1, 0, 0),
                                        glm::dvec4(0, 0, -1, 0),
                                        glm::dvec4(0, 0, 20, 1));
  return camera;
}

// The pixel that sees the shadow, cast by `sun`, of a point of the wall's rim.
glm::dvec2 PixelOfShadow(const glm::dvec3& rim_m, const glm::dvec3& sun) {
  const glm::dvec3 shadow = rim_m - sun * (rim_m.z / sun.z);
  return {399.5 + 500.0 * shadow.x / 20.0, 299.5 - 500.0 * shadow.y / 20.0};
}

std::vector<ShadowEdgeMark> MarksUnder(const glm::dvec3& real_sun, const glm::dvec3& computed_sun) {
  std::vector<ShadowEdgeMark> marks;
  for (const glm::dvec3& rim : {glm::dvec3(-2, 0, kWallHeightM),
                                glm::dvec3(2, 0, kWallHeightM),
                                glm::dvec3(3, 0, 2.0),
                                glm::dvec3(3, 0, 3.0),
                                glm::dvec3(-3, 0, 2.5)}) {
    marks.push_back({LookingDown(), PixelOfShadow(rim, real_sun), computed_sun});
  }
  return marks;
}

TEST(ShadowEdgeMarks, FitTheSunThatCastThem) {
  const glm::dvec3 sun = Sun(200.0, 40.0);
  const RayCaster mesh(GroundAndWall());
  const ShadowEdgeFit fit = FitShadowEdges(mesh, MarksUnder(sun, sun));
  ASSERT_EQ(fit.used, 5u);
  // The outline is known to half a step of the raster.
  EXPECT_LE(fit.largest_rad, kShadowEdgeStepRad);
  ASSERT_TRUE(fit.azimuth_offset_rad.has_value());
  EXPECT_NEAR(*fit.azimuth_offset_rad, 0.0, 2.0 * kShadowEdgeStepRad);
}

TEST(ShadowEdgeMarks, MeasureHowFarTheSunIsTurned) {
  const glm::dvec3 sun = Sun(200.0, 40.0);
  const RayCaster mesh(GroundAndWall());
  for (const double turn_deg : {-4.0, 1.0, 3.0}) {
    const double turn = RadFromDeg(turn_deg);
    const ShadowEdgeFit fit = FitShadowEdges(mesh, MarksUnder(TurnedClockwise(sun, turn), sun));
    ASSERT_TRUE(fit.azimuth_offset_rad.has_value());
    EXPECT_NEAR(*fit.azimuth_offset_rad, turn, 2.0 * kShadowEdgeStepRad) << turn_deg << " deg";
    EXPECT_GT(fit.rms_rad, fit.rms_after_rad);
    EXPECT_LE(fit.rms_after_rad, kShadowEdgeStepRad);
    // An upright edge sees the turn under the cosine of the sun's elevation and more slanted.
    EXPECT_LE(fit.largest_rad, std::abs(turn));
  }
}

TEST(ShadowEdgeMarks, FarFromAnyShadowHaveNoAngle) {
  const glm::dvec3 sun = Sun(200.0, 40.0);
  const RayCaster mesh(GroundAndWall());
  std::vector<ShadowEdgeMark> marks = MarksUnder(sun, sun);
  marks.resize(2);
  marks.push_back({LookingDown(), {50.0, 550.0}, sun});
  const ShadowEdgeFit fit = FitShadowEdges(mesh, marks);
  EXPECT_EQ(fit.used, 2u);
  EXPECT_FALSE(fit.angle_rad[2].has_value());
  EXPECT_FALSE(fit.azimuth_offset_rad.has_value()) << "two marks leave no doubt to measure";
}

TEST(ShadowEdgeMarks, RefuseASunBelowTheHorizon) {
  const RayCaster mesh(GroundAndWall());
  const std::vector<ShadowEdgeMark> marks = {{LookingDown(), {400.0, 300.0}, Sun(200.0, -1.0)}};
  EXPECT_THROW(FitShadowEdges(mesh, marks), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::shadow_edge_marks_test

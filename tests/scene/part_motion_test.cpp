#include "scene/part_motion.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace pleinair::part_motion_test {
namespace {

using Interpolation = KeyTrack::Interpolation;

KeyTrack Track(Interpolation interpolation, std::vector<glm::dvec4> values) {
  return {{1.0, 3.0}, std::move(values), interpolation};
}

TEST(KeyTrack, StaysAtItsEndsOutsideItsKeys) {
  const glm::dvec4 a(1.0, 2.0, 3.0, 0.0);
  const glm::dvec4 b(5.0, 0.0, 3.0, 0.0);
  for (const Interpolation interpolation : {Interpolation::kStep, Interpolation::kLinear}) {
    EXPECT_EQ(Track(interpolation, {a, b}).At(0.0), a);
    EXPECT_EQ(Track(interpolation, {a, b}).At(1.0), a);
    EXPECT_EQ(Track(interpolation, {a, b}).At(3.0), b);
    EXPECT_EQ(Track(interpolation, {a, b}).At(9.0), b);
  }
}

TEST(KeyTrack, StepsAndGoesStraight) {
  const glm::dvec4 a(0.0);
  const glm::dvec4 b(4.0);
  EXPECT_EQ(Track(Interpolation::kStep, {a, b}).At(2.999), a);
  EXPECT_EQ(Track(Interpolation::kLinear, {a, b}).At(1.5), glm::dvec4(1.0));
}

// A cubic Hermite spline reproduces every cubic: x^3 with its own tangents, 3 x^2.
TEST(KeyTrack, ASplineGivesACubicBack) {
  const auto key = [](double x) {
    const glm::dvec4 tangent(3.0 * x * x);
    return std::vector<glm::dvec4>{tangent, glm::dvec4(x * x * x), tangent};
  };
  std::vector<glm::dvec4> values = key(1.0);
  for (const glm::dvec4& value : key(3.0)) values.push_back(value);
  const KeyTrack track = Track(Interpolation::kCubicSpline, values);
  for (const double x : {1.0, 1.3, 2.0, 2.9, 3.0}) {
    EXPECT_NEAR(track.At(x).x, x * x * x, 1e-12 * 27.0);
  }
  EXPECT_EQ(track.At(7.0), glm::dvec4(27.0));
}

// Halfway of a turn by 90 deg about z is one by 45 deg, whichever of the two quaternions of the
// second pose the file has.
TEST(KeyTrack, TurnsAlongTheShorterArc) {
  const double half = std::numbers::pi / 4.0;
  for (const double sign : {1.0, -1.0}) {
    const KeyTrack track =
        Track(Interpolation::kLinear,
              {{0.0, 0.0, 0.0, 1.0}, sign * glm::dvec4(0.0, 0.0, std::sin(half), std::cos(half))});
    const glm::dvec3 turned = track.RotationAt(2.0) * glm::dvec3(1.0, 0.0, 0.0);
    EXPECT_NEAR(glm::distance(turned, glm::dvec3(std::sqrt(0.5), std::sqrt(0.5), 0.0)), 0.0, 1e-12);
  }
}

MovingNode Shifted(double from, double to) {
  MovingNode node;
  node.translation_track = KeyTrack{{0.0, 2.0}, {{from, 0.0, 0.0, 0.0}, {to, 0.0, 0.0, 0.0}}};
  return node;
}

TEST(PartMotion, GoesDownItsChainOfNodes) {
  MovingNode turned;
  turned.rest = glm::rotate(glm::dmat4(1.0), std::numbers::pi / 2.0, glm::dvec3(0.0, 0.0, 1.0));
  const PartMotion motion({turned, Shifted(1.0, 3.0)}, 2.0);
  // The shift is along the turned x: y.
  const glm::dvec4 at = motion.FileFromPart(1.0) * glm::dvec4(0.0, 0.0, 0.0, 1.0);
  EXPECT_NEAR(glm::distance(glm::dvec3(at), glm::dvec3(0.0, 2.0, 0.0)), 0.0, 1e-12);
  const glm::dvec4 moved = motion.FileFromStart(1.0) * glm::dvec4(5.0, 0.0, 0.0, 1.0);
  EXPECT_NEAR(glm::distance(glm::dvec3(moved), glm::dvec3(5.0, 1.0, 0.0)), 0.0, 1e-12);
}

TEST(PartMotion, RepeatsAfterItsEndAndBeforeItsBeginning) {
  const PartMotion motion({Shifted(0.0, 4.0)}, 2.0);
  for (const double time_s : {0.5, 2.5, 200.5, -1.5}) {
    EXPECT_NEAR(motion.FileFromPart(time_s)[3].x, 1.0, 1e-12) << time_s;
  }
  EXPECT_EQ(motion.FileFromStart(0.0), glm::dmat4(1.0));
  EXPECT_EQ(motion.FileFromStart(2.0), glm::dmat4(1.0));
}

TEST(PartMotion, StandsStillWithoutNodes) {
  EXPECT_FALSE(PartMotion().Moves());
  EXPECT_EQ(PartMotion().FileFromStart(3.0), glm::dmat4(1.0));
}

TEST(PartMotion, RefusesWhatMakesNoSense) {
  EXPECT_THROW(PartMotion({Shifted(0.0, 1.0)}, 0.0), std::invalid_argument);
  EXPECT_THROW(PartMotion({Shifted(0.0, 1.0)}, NAN), std::invalid_argument);
  MovingNode flat;
  flat.scale_track = KeyTrack{{0.0, 1.0}, {{1.0, 0.0, 1.0, 0.0}, {1.0, 1.0, 1.0, 0.0}}};
  EXPECT_THROW(PartMotion({flat}, 1.0).FileFromStart(0.5), std::runtime_error);
}

}  // namespace
}  // namespace pleinair::part_motion_test

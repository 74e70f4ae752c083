#include "scene/spherical_harmonics.h"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/lat_long.h"

namespace pleinair::spherical_harmonics_test {
namespace {

constexpr double kPi = std::numbers::pi;

glm::dvec3 RandomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

std::vector<double> Basis(int bands, const glm::dvec3& direction) {
  std::vector<double> values(static_cast<std::size_t>(ShCoefficientCount(bands)));
  EvaluateShBasis(bands, direction, values);
  return values;
}

// Ramamoorthi and Hanrahan 2001, equation 3 (their x, y, z are ours).
TEST(SphericalHarmonics, AgreeWithThePublishedConstants) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 d = RandomDirection(random);
    const std::vector<double> basis = Basis(3, d);
    EXPECT_NEAR(basis[0], 0.282095, 5e-7);
    EXPECT_NEAR(basis[1], 0.488603 * d.y, 5e-7);
    EXPECT_NEAR(basis[2], 0.488603 * d.z, 5e-7);
    EXPECT_NEAR(basis[3], 0.488603 * d.x, 5e-7);
    EXPECT_NEAR(basis[4], 1.092548 * d.x * d.y, 5e-7);
    EXPECT_NEAR(basis[5], 1.092548 * d.y * d.z, 5e-7);
    EXPECT_NEAR(basis[6], 0.315392 * (3.0 * d.z * d.z - 1.0), 1e-6);
    EXPECT_NEAR(basis[7], 1.092548 * d.x * d.z, 5e-7);
    EXPECT_NEAR(basis[8], 0.546274 * (d.x * d.x - d.y * d.y), 5e-7);
  }
}

TEST(SphericalHarmonics, ProbeBasisAgreesWithTheGeneralOne) {
  std::mt19937 random(2);
  for (int i = 0; i < 1000; ++i) {
    const glm::vec3 direction(RandomDirection(random));
    const auto fast = EvaluateShBasis9(direction);
    const std::vector<double> general = Basis(3, glm::dvec3(direction));
    for (std::size_t k = 0; k < fast.size(); ++k) EXPECT_NEAR(fast[k], general[k], 4e-7f);
  }
}

// Ramamoorthi and Hanrahan 2001, equation 8; the last two by its recurrence.
TEST(SphericalHarmonics, CosineLobeFactorsAreThePublishedOnes) {
  EXPECT_NEAR(CosineLobeFactor(0), kPi, 1e-15);
  EXPECT_NEAR(CosineLobeFactor(1), 2.0 * kPi / 3.0, 1e-15);
  EXPECT_NEAR(CosineLobeFactor(2), kPi / 4.0, 1e-15);
  EXPECT_EQ(CosineLobeFactor(3), 0.0);
  EXPECT_NEAR(CosineLobeFactor(4), -kPi / 24.0, 1e-15);
  EXPECT_EQ(CosineLobeFactor(5), 0.0);
  EXPECT_NEAR(CosineLobeFactor(6), kPi / 64.0, 1e-15);
  EXPECT_NEAR(CosineLobeFactor(8), -kPi / 128.0, 1e-15);
  EXPECT_THROW(CosineLobeFactor(-1), std::invalid_argument);
}

TEST(SphericalHarmonics, AConstantSkyGivesPiTimesItsRadiance) {
  ShRgb radiance{};
  radiance[0] = glm::vec3(3.0f, 2.0f, 1.0f) * static_cast<float>(std::sqrt(4.0 * kPi));
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const glm::vec3 irradiance = IrradianceFromSh(radiance, glm::vec3(RandomDirection(random)));
    // Four roundings of single precision.
    EXPECT_NEAR(irradiance.r, 3.0 * kPi, 4 * 6e-8 * 3.0 * kPi);
    EXPECT_NEAR(irradiance.g, 2.0 * kPi, 4 * 6e-8 * 2.0 * kPi);
    EXPECT_NEAR(irradiance.b, 1.0 * kPi, 4 * 6e-8 * 1.0 * kPi);
  }
}

// A second method: the irradiance of a smooth sky (bands 0 to 2 only), summed pixel by pixel.
TEST(SphericalHarmonics, IrradianceAgreesWithSummingPixels) {
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  ShRgb radiance{};
  for (glm::vec3& coefficient : radiance) coefficient = glm::vec3(normal(random));
  radiance[0] = glm::vec3(20.0f);  // So that no radiance is negative.
  const LatLongSize size{512, 256};
  for (const glm::dvec3& direction : {glm::dvec3(0.0, 0.0, 1.0), RandomDirection(random)}) {
    double sum = 0.0;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const glm::dvec3 to_light = DirectionFromLatLong({x + 0.5, y + 0.5}, size);
        const double cosine = glm::dot(direction, to_light);
        if (cosine <= 0.0) continue;
        const auto basis = EvaluateShBasis9(glm::vec3(to_light));
        double value = 0.0;
        for (std::size_t k = 0; k < basis.size(); ++k) value += basis[k] * radiance[k].r;
        sum += value * cosine * LatLongPixelSolidAngleSr(y, size);
      }
    }
    // The midpoint rule at 0.7 degrees: of order (0.012)^2 / 24 of the sum.
    EXPECT_NEAR(IrradianceFromSh(radiance, glm::vec3(direction)).r, sum, 3e-5 * sum);
  }
}

TEST(SphericalHarmonics, RefuseOtherSizes) {
  std::vector<double> values(8);
  EXPECT_THROW(EvaluateShBasis(3, {0.0, 0.0, 1.0}, values), std::invalid_argument);
  EXPECT_THROW(EvaluateShBasis(0, {0.0, 0.0, 1.0}, values), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::spherical_harmonics_test

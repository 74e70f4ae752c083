#include "scene/spherical_harmonics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace pleinair::spherical_harmonics_hard_cases_test {
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

// Simpson's rule in the height over 4000 steps, equal steps in azimuth: exact in azimuth, and for
// polynomials of degree 2 * 7 in the height to (14 / 4000)^4 = 2e-10.
TEST(SphericalHarmonicsHardCases, AreOrthonormal) {
  constexpr int kBands = 8;
  constexpr int kSteps = 4000;
  constexpr int kAzimuths = 2 * kBands;
  const std::size_t count = static_cast<std::size_t>(ShCoefficientCount(kBands));
  std::vector<double> gram(count * count, 0.0);
  for (int step = 0; step <= kSteps; ++step) {
    const double height = -1.0 + 2.0 * step / kSteps;
    const double simpson = step == 0 || step == kSteps ? 1.0 : (step % 2 == 1 ? 4.0 : 2.0);
    const double weight = simpson * (2.0 / kSteps) / 3.0 * 2.0 * kPi / kAzimuths;
    const double radius = std::sqrt(std::max(0.0, 1.0 - height * height));
    for (int i = 0; i < kAzimuths; ++i) {
      const double azimuth = 2.0 * kPi * (i + 0.25) / kAzimuths;
      const std::vector<double> basis =
          Basis(kBands, {radius * std::cos(azimuth), radius * std::sin(azimuth), height});
      for (std::size_t a = 0; a < count; ++a) {
        for (std::size_t b = 0; b < count; ++b) gram[a * count + b] += weight * basis[a] * basis[b];
      }
    }
  }
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = 0; b < count; ++b) {
      EXPECT_NEAR(gram[a * count + b], a == b ? 1.0 : 0.0, 1e-6) << a << " " << b;
    }
  }
}

// Unsoeld's theorem: the squares of a band add up to (2 l + 1) / (4 pi) in every direction, poles
// included. Holds for many bands only if the recurrence is stable.
TEST(SphericalHarmonicsHardCases, BandsKeepTheirPowerUpToSixtyFour) {
  constexpr int kBands = 64;
  std::mt19937 random(5);
  std::vector<glm::dvec3> directions = {
      {0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}, {1.0, 0.0, 0.0}, {1e-9, 0.0, 1.0}};
  for (int i = 0; i < 100; ++i) directions.push_back(RandomDirection(random));
  for (const glm::dvec3& direction : directions) {
    const std::vector<double> basis = Basis(kBands, direction);
    for (int l = 0; l < kBands; ++l) {
      double power = 0.0;
      for (int k = l * l; k < (l + 1) * (l + 1); ++k) {
        power += basis[static_cast<std::size_t>(k)] * basis[static_cast<std::size_t>(k)];
      }
      const double expected = (2.0 * l + 1.0) / (4.0 * kPi);
      EXPECT_NEAR(power, expected, 1e-12 * expected * kBands) << "band " << l;
    }
  }
}

ShRgb DirectionalSource(const glm::vec3& direction, const glm::vec3& irradiance) {
  ShRgb radiance{};
  const auto basis = EvaluateShBasis9(direction);
  for (std::size_t k = 0; k < basis.size(); ++k) radiance[k] = irradiance * basis[k];
  return radiance;
}

// Irradiance of three bands before the clamp of IrradianceFromSh.
double Unclamped(const ShRgb& radiance, const glm::dvec3& normal) {
  const std::vector<double> basis = Basis(3, normal);
  double sum = 0.0;
  for (int l = 0; l < 3; ++l) {
    for (int k = l * l; k < (l + 1) * (l + 1); ++k) {
      const std::size_t i = static_cast<std::size_t>(k);
      sum += CosineLobeFactor(l) * basis[i] * radiance[i].r;
    }
  }
  return sum;
}

// Without the window a source rings to -4 % of its irradiance. With it: (1 + sqrt(3) t)^2 / 8,
// which touches zero; 1e-6 is the rounding of the nine single-precision coefficients.
TEST(SphericalHarmonicsHardCases, WindowedIrradianceIsNeverNegative) {
  std::mt19937 random(7);
  double lowest_plain = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    const glm::dvec3 to_source = RandomDirection(random);
    const ShRgb plain = DirectionalSource(glm::vec3(to_source), glm::vec3(1.0f));
    ShRgb windowed = plain;
    WindowSh(windowed);
    for (int i = 0; i < 5000; ++i) {
      const glm::dvec3 normal = RandomDirection(random);
      const double cosine = glm::dot(normal, to_source);
      const double expected = std::pow(1.0 + std::sqrt(3.0) * cosine, 2.0) / 8.0;
      EXPECT_NEAR(Unclamped(windowed, normal), expected, 1e-6);
      EXPECT_GE(Unclamped(windowed, normal), -1e-6);
      EXPECT_GE(IrradianceFromSh(plain, glm::vec3(normal)).r, 0.0f);
      lowest_plain = std::min(lowest_plain, Unclamped(plain, normal));
    }
  }
  EXPECT_LT(lowest_plain, -0.035) << "the directions did not reach the negative lobe";
}

TEST(SphericalHarmonicsHardCases, WindowLeavesAConstantSkyAlone) {
  ShRgb radiance{};
  radiance[0] = glm::vec3(1.0f, 2.0f, 3.0f);
  ShRgb windowed = radiance;
  WindowSh(windowed);
  EXPECT_EQ(windowed, radiance);
}

}  // namespace
}  // namespace pleinair::spherical_harmonics_hard_cases_test

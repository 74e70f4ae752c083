#include "scene/lat_long.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace pleinair::lat_long_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr LatLongSize kSize{1024, 512};

void ExpectNear(const glm::dvec3& actual, const glm::dvec3& expected, double tolerance) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(actual.z, expected.z, tolerance);
}

// The mapping in words: centre north, east right of it, top zenith. 1e-15: rounding of sin and cos.
TEST(LatLong, PutsTheQuartersWhereTheHeaderSays) {
  ExpectNear(DirectionFromLatLong({512.0, 256.0}, kSize), {0.0, 1.0, 0.0}, 1e-15);
  ExpectNear(DirectionFromLatLong({768.0, 256.0}, kSize), {1.0, 0.0, 0.0}, 1e-15);
  ExpectNear(DirectionFromLatLong({256.0, 256.0}, kSize), {-1.0, 0.0, 0.0}, 1e-15);
  ExpectNear(DirectionFromLatLong({0.0, 256.0}, kSize), {0.0, -1.0, 0.0}, 1e-15);
  ExpectNear(DirectionFromLatLong({512.0, 0.0}, kSize), {0.0, 0.0, 1.0}, 1e-15);
  ExpectNear(DirectionFromLatLong({512.0, 512.0}, kSize), {0.0, 0.0, -1.0}, 1e-15);
}

TEST(LatLong, FindsThePixelOfADirection) {
  EXPECT_EQ(LatLongPixelFromDirection({0.001, 1.0, 0.001}, kSize), glm::ivec2(512, 255));
  EXPECT_EQ(LatLongPixelFromDirection({-0.001, 1.0, -0.001}, kSize), glm::ivec2(511, 256));
  EXPECT_EQ(LatLongPixelFromDirection({0.0, 0.0, -5.0}, kSize), glm::ivec2(512, 511));
}

TEST(LatLong, TakesDirectionsOfAnyLength) {
  const glm::dvec3 direction(0.3, -0.5, 0.2);
  const glm::dvec2 unit = LatLongFromDirection(glm::normalize(direction), kSize);
  for (const double length : {1e-300, 1e-20, 1e20, 1e300}) {
    const glm::dvec2 uv = LatLongFromDirection(length * direction, kSize);
    EXPECT_NEAR(uv.x, unit.x, 1e-9);
    EXPECT_NEAR(uv.y, unit.y, 1e-9);
  }
}

// Archimedes: the band between two heights has 2 pi times their difference.
TEST(LatLong, SolidAnglesAreThoseOfBands) {
  for (const int y : {0, 1, 200, 255, 256, 511}) {
    const double top = std::sin((0.5 - y / 512.0) * kPi);
    const double bottom = std::sin((0.5 - (y + 1) / 512.0) * kPi);
    // 1e-16 of the difference's terms, near 1 at the poles.
    EXPECT_NEAR(LatLongPixelSolidAngleSr(y, kSize) * 1024, 2.0 * kPi * (top - bottom), 2e-15);
  }
}

TEST(LatLong, SamplesPixelCentresExactly) {
  RgbImage image(6, 4);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    image.pixels[i] = glm::vec3(static_cast<float>(i), static_cast<float>(2 * i), 1.0f);
  }
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, {6, 4});
      ExpectNear(SampleLatLong(image, direction), image.At(x, y), 1e-5);
    }
  }
}

TEST(LatLong, SamplesWrapAroundTheSeam) {
  RgbImage image(4, 1);
  image.At(0, 0) = glm::vec3(1.0f);
  image.At(3, 0) = glm::vec3(3.0f);
  EXPECT_NEAR(SampleLatLong(image, {0.0, -1.0, 0.0}).x, 2.0, 1e-6);
}

// At the zenith the top row meets itself half way round, so the sample is the mean of two opposite
// ones and the look-up is continuous across the pole.
TEST(LatLong, SamplesAreContinuousOverThePoles) {
  for (const int width : {7, 8}) {
    RgbImage image(width, 4);
    for (int x = 0; x < width; ++x) image.At(x, 0) = glm::vec3(std::sin(static_cast<float>(x)));
    for (double azimuth = 0.0; azimuth < kPi; azimuth += 0.1) {
      const double tiny = 1e-9;
      const glm::dvec3 before(tiny * std::sin(azimuth), tiny * std::cos(azimuth), 1.0);
      const glm::dvec3 behind(-before.x, -before.y, 1.0);
      EXPECT_NEAR(SampleLatLong(image, before).x, SampleLatLong(image, behind).x, 1e-6);
    }
  }
}

TEST(LatLong, ReductionKeepsTheIntegral) {
  RgbImage image(24, 12);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    image.pixels[i] = glm::vec3(std::sin(static_cast<float>(i)) + 1.0f, 1.0f, 0.0f);
  }
  const auto integral = [](const RgbImage& map) {
    glm::dvec3 sum(0.0);
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        sum += LatLongPixelSolidAngleSr(y, {map.width, map.height}) * glm::dvec3(map.At(x, y));
      }
    }
    return sum;
  };
  // Float pixels: 6e-8 relative of 4 pi.
  for (const LatLongSize size : {LatLongSize{12, 6}, {8, 3}, {24, 1}, {1, 1}}) {
    ExpectNear(integral(DownsampleLatLong(image, size)), integral(image), 1e-6);
  }
}

TEST(LatLong, RefusesSizesThatDoNotDivide) {
  const RgbImage image(8, 4);
  EXPECT_THROW(DownsampleLatLong(image, {3, 2}), std::invalid_argument);
  EXPECT_THROW(DownsampleLatLong(image, {16, 4}), std::invalid_argument);
  EXPECT_THROW(DownsampleLatLong(image, {0, 0}), std::invalid_argument);
}

// 22.5 deg are two of 32 columns; a third of a column keeps each row's light.
TEST(TurnedLatLong, TakesWhatIsInTheNorthClockwise) {
  RgbImage image(32, 16, glm::vec3(0.0f));
  const glm::ivec2 north = LatLongPixelFromDirection({0.0, 1.0, 0.5}, {32, 16});
  image.At(north.x, north.y) = glm::vec3(8.0f, 4.0f, 2.0f);
  const RgbImage turned = TurnedLatLong(image, std::numbers::pi / 8.0);
  EXPECT_EQ(turned.At(north.x + 2, north.y), image.At(north.x, north.y));
  EXPECT_EQ(TurnedLatLong(turned, -std::numbers::pi / 8.0).pixels, image.pixels);
  const RgbImage part = TurnedLatLong(image, std::numbers::pi / 48.0);
  EXPECT_NEAR(part.At(north.x, north.y).x, 8.0f * 2.0f / 3.0f, 1e-5f);
  EXPECT_NEAR(part.At(north.x + 1, north.y).x, 8.0f / 3.0f, 1e-5f);
  EXPECT_THROW(TurnedLatLong(RgbImage(), 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::lat_long_test

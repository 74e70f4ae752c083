#include "scene/lat_long.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "scene/angle_between.h"

namespace pleinair::lat_long_hard_cases_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr LatLongSize kSizes[] = {
    {1, 1}, {2, 1}, {1, 2}, {3, 3}, {5, 7}, {17, 4}, {64, 32}, {101, 51}, {333, 1000}, {1024, 512}};

TEST(LatLongHardCases, EveryPixelOfEverySizeComesBack) {
  for (const LatLongSize size : kSizes) {
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const glm::dvec3 direction = DirectionFromLatLong({x + 0.5, y + 0.5}, size);
        ASSERT_EQ(LatLongPixelFromDirection(direction, size), glm::ivec2(x, y))
            << size.width << "x" << size.height;
        const glm::dvec3 again = DirectionFromLatLong(LatLongFromDirection(direction, size), size);
        ASSERT_LE(AngleBetweenRad(direction, again), 1e-6);
        ASSERT_NEAR(glm::length(direction), 1.0, 1e-15);
      }
    }
  }
}

// Corners of pixels, so poles and seam too: there the image point may differ, the direction not.
TEST(LatLongHardCases, PolesAndSeamKeepTheirDirection) {
  for (const LatLongSize size : kSizes) {
    for (int y = 0; y <= size.height; ++y) {
      for (int x = 0; x <= size.width; ++x) {
        const glm::dvec3 direction = DirectionFromLatLong({x, y}, size);
        const glm::dvec2 uv = LatLongFromDirection(direction, size);
        ASSERT_GE(uv.x, 0.0);
        ASSERT_LT(uv.x, size.width);
        ASSERT_GE(uv.y, 0.0);
        ASSERT_LE(uv.y, size.height);
        ASSERT_LE(AngleBetweenRad(direction, DirectionFromLatLong(uv, size)), 1e-6);
        const glm::ivec2 pixel = LatLongPixelFromDirection(direction, size);
        ASSERT_TRUE(pixel.x >= 0 && pixel.x < size.width && pixel.y >= 0 && pixel.y < size.height);
      }
    }
  }
}

TEST(LatLongHardCases, PolesLieOnTheCentreColumn) {
  for (const LatLongSize size : kSizes) {
    EXPECT_EQ(LatLongFromDirection({0.0, 0.0, 1.0}, size), glm::dvec2(size.width / 2.0, 0.0));
    EXPECT_EQ(LatLongFromDirection({-0.0, -0.0, -1.0}, size),
              glm::dvec2(size.width / 2.0, size.height));
  }
}

// Either side of due south, and the zeros of either sign on it.
TEST(LatLongHardCases, TheSeamIsInsideTheImage) {
  for (const double east : {-1e-300, -1e-17, -0.0, 0.0, 1e-17, 1e-300}) {
    const glm::dvec2 uv = LatLongFromDirection({east, -1.0, 0.0}, {360, 180});
    EXPECT_GE(uv.x, 0.0);
    EXPECT_LT(uv.x, 360.0);
  }
}

TEST(LatLongHardCases, SolidAnglesAddUpToTheSphere) {
  for (const LatLongSize size : kSizes) {
    double sum = 0.0;
    for (int y = 0; y < size.height; ++y) sum += size.width * LatLongPixelSolidAngleSr(y, size);
    EXPECT_NEAR(sum, 4.0 * kPi, 1e-12) << size.width << "x" << size.height;
  }
}

TEST(LatLongHardCases, RefusesDirectionsWithoutMeaning) {
  for (const glm::dvec3& direction : {glm::dvec3(0.0),
                                      glm::dvec3(kNaN, 0.0, 1.0),
                                      glm::dvec3(0.0, 0.0, kNaN),
                                      glm::dvec3(0.0, kInfinity, 1.0),
                                      glm::dvec3(0.0, 0.0, -kInfinity)}) {
    EXPECT_THROW(LatLongFromDirection(direction, {4, 2}), std::invalid_argument);
    EXPECT_THROW(LatLongPixelFromDirection(direction, {4, 2}), std::invalid_argument);
    EXPECT_THROW(SampleLatLong(RgbImage(4, 2), direction), std::invalid_argument);
  }
}

TEST(LatLongHardCases, RefusesSizesWithoutPixels) {
  for (const LatLongSize size : {LatLongSize{0, 0}, {0, 4}, {4, 0}, {-4, 2}}) {
    EXPECT_THROW(DirectionFromLatLong({0.5, 0.5}, size), std::invalid_argument);
    EXPECT_THROW(LatLongFromDirection({0.0, 1.0, 0.0}, size), std::invalid_argument);
    EXPECT_THROW(LatLongPixelSolidAngleSr(0, size), std::invalid_argument);
  }
  EXPECT_THROW(LatLongPixelSolidAngleSr(4, {8, 4}), std::invalid_argument);
  EXPECT_THROW(LatLongPixelSolidAngleSr(-1, {8, 4}), std::invalid_argument);
  EXPECT_THROW(SampleLatLong(RgbImage(), {0.0, 1.0, 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::lat_long_hard_cases_test

// Strong distortion, points behind the camera, and far outside what a lens model is good for.
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/lens.h"

namespace pleinair::lens_hard_cases_test {
namespace {

// What the catalogue of hard cases promises inside the stated validity.
constexpr double kRoundTripPx = 1e-6;

CameraIntrinsics RandomCamera(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  CameraIntrinsics camera{1920, 1080, 0.0, 0.0, 0.0, 0.0, {}};
  camera.fx_px = 1000.0 * std::exp(unit(random));
  camera.fy_px = camera.fx_px * std::exp(0.1 * unit(random));
  camera.cx_px = 960.0 + 200.0 * unit(random);
  camera.cy_px = 540.0 + 200.0 * unit(random);
  camera.distortion = {0.8 * unit(random),
                       0.8 * unit(random),
                       0.02 * unit(random),
                       0.02 * unit(random),
                       0.8 * unit(random)};
  return camera;
}

TEST(LensHardCases, RoundTripsAllOverTheValidityOfStrongDistortion) {
  constexpr std::uint64_t kSeed = 20260801;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int folding = 0;
  int unfolding = 0;
  for (int c = 0; c < 400; ++c) {
    const CameraIntrinsics camera = RandomCamera(random);
    const Lens lens(camera);
    (lens.ValidRadius() < 10.0 ? folding : unfolding) += 1;
    for (int i = 0; i < 100; ++i) {
      // Up to the very rim, with one point in ten within 1e-3 ... 1e-9 of it.
      const double to_rim =
          i % 10 == 0 ? 1.0 - std::pow(10.0, -3.0 - 6.0 * unit(random)) : std::sqrt(unit(random));
      const double radius = std::min(lens.ValidRadius(), 20.0) * to_rim;
      const double angle = 2.0 * M_PI * unit(random);
      const auto pixel =
          lens.ProjectToPixel({radius * std::cos(angle), radius * std::sin(angle), 1.0});
      // Only the bound on the picture's extent may refuse inside the radius: at radius 4 the
      // picture is still within 2719 px * 0.8 * 4^7 = 4e7 px, k1 and k2 adding a tenth.
      if (!pixel) {
        EXPECT_GT(radius, 4.0);
        continue;
      }
      const auto direction = lens.DirectionFromPixel(*pixel);
      ASSERT_TRUE(direction) << "camera " << c << ", radius " << radius << " of "
                             << lens.ValidRadius();
      const auto again = lens.ProjectToPixel(*direction);
      ASSERT_TRUE(again);
      // Beyond 1e4 px the rounding of the pixel's own coordinates is added.
      const double rounding = 1e-12 * glm::length(*pixel);
      EXPECT_LE(glm::distance(*again, *pixel), kRoundTripPx + rounding);
    }
  }
  EXPECT_GT(folding, 50);
  EXPECT_GT(unfolding, 50);
}

// One pixel has one direction: away from the rim, where the mapping is well conditioned, the
// direction comes back too.
TEST(LensHardCases, FindsTheDirectionThatMadeThePixel) {
  std::mt19937_64 random(99);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int c = 0; c < 200; ++c) {
    const CameraIntrinsics camera = RandomCamera(random);
    const Lens lens(camera);
    for (int i = 0; i < 50; ++i) {
      const double radius = std::min(lens.ValidRadius(), 3.0) * 0.9 * unit(random);
      const double angle = 2.0 * M_PI * unit(random);
      const glm::dvec3 direction =
          glm::normalize(glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), 1.0));
      const auto pixel = lens.ProjectToPixel(direction);
      ASSERT_TRUE(pixel);
      const auto found = lens.DirectionFromPixel(*pixel);
      ASSERT_TRUE(found);
      // 1e-7 px of residual, over a focal length of at least 360 px and a slope of at least 0.01.
      EXPECT_LT(glm::distance(*found, direction), 1e-7);
    }
  }
}

TEST(LensHardCases, RefusesWhatLiesBeyondTheFold) {
  CameraIntrinsics camera{640, 480, 400.0, 400.0, 319.5, 239.5, {-0.4, 0.0, 0.0, 0.0, 0.0}};
  const Lens lens(camera);
  const double rim = lens.ValidRadius();
  EXPECT_NEAR(rim, std::sqrt(1.0 / 1.2), 1e-12);  // 1 - 3 * 0.4 r^2 = 0.
  EXPECT_TRUE(lens.ProjectToPixel({rim * (1.0 - 1e-9), 0.0, 1.0}));
  EXPECT_FALSE(lens.ProjectToPixel({rim * (1.0 + 1e-9), 0.0, 1.0}));
  // The farthest image point is r (1 - 0.4 r^2) = 2/3 rim: nothing maps beyond.
  const double farthest_px = 400.0 * rim * 2.0 / 3.0;
  EXPECT_TRUE(lens.DirectionFromPixel({319.5 + farthest_px - 1e-3, 239.5}));
  EXPECT_FALSE(lens.DirectionFromPixel({319.5 + farthest_px + 1e-3, 239.5}));
  EXPECT_FALSE(lens.DirectionFromPixel({1e7, -1e7}));
}

TEST(LensHardCases, RefusesPointsBehindTheCameraThatWouldMirrorIntoThePicture) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int c = 0; c < 100; ++c) {
    const CameraIntrinsics camera = RandomCamera(random);
    const Lens lens(camera);
    const double depth = -std::exp(10.0 * unit(random));
    EXPECT_FALSE(lens.ProjectToPixel({unit(random) * depth, unit(random) * depth, depth}));
  }
}

// A fish-eye's 90 degrees and beyond are no pinhole camera's: refused, never infinite.
TEST(LensHardCases, RefusesTheRightAngle) {
  const CameraIntrinsics camera{640, 480, 400.0, 400.0, 319.5, 239.5, {}};
  EXPECT_FALSE(ProjectToPixel(camera, {1.0, 0.0, 0.0}));
  EXPECT_FALSE(ProjectToPixel(camera, {1.0, 0.0, 1e-9}));
  EXPECT_FALSE(ProjectToPixel(camera, {1.0, 0.0, -0.0}));
}

TEST(LensHardCases, CoversThePictureOfALensThatFoldsInsideIt) {
  // The rim, r = 0.5774, maps to 0.385 * 400 = 154 px: inside the picture on both axes.
  const CameraIntrinsics camera{640, 480, 400.0, 400.0, 319.5, 239.5, {-1.0, 0.0, 0.0, 0.0, 0.0}};
  const CameraIntrinsics cover = UndistortedCover(camera);
  const double reach_px = 400.0 * Lens(camera).ValidRadius();
  EXPECT_NEAR(cover.width_px, 2.0 * (reach_px + 1.0), 2.0);
  EXPECT_NEAR(cover.height_px, 2.0 * (reach_px + 1.0), 2.0);
}

TEST(LensHardCases, CoversAOnePixelPicture) {
  const CameraIntrinsics camera{1, 1, 1.0, 1.0, 0.0, 0.0, {-0.1, 0.0, 0.0, 0.0, 0.0}};
  const CameraIntrinsics cover = UndistortedCover(camera);
  EXPECT_GE(cover.width_px, 3);
  EXPECT_LE(cover.width_px, 6);
}

TEST(LensHardCases, RefusesACoverThatNoMemoryHolds) {
  // The picture's corners reach r (1 - 0.3333 r^2 ...) close to the fold of a very long lens curve.
  const CameraIntrinsics camera{
      16000, 16000, 8000.0, 8000.0, 7999.5, 7999.5, {-0.12, 0.0, 0.0, 0.0, 0.0}};
  EXPECT_THROW(UndistortedCover(camera), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::lens_hard_cases_test

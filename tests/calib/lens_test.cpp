#include "calib/lens.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <opencv2/calib3d.hpp>

namespace pleinair::lens_test {
namespace {

constexpr CameraIntrinsics kPinhole{640, 480, 500.0, 510.0, 319.5, 239.5, {}};
constexpr CameraIntrinsics kDistorted{
    640, 480, 500.0, 510.0, 319.5, 239.5, {-0.28, 0.09, 0.0012, -0.0007, -0.012}};

TEST(Lens, PutsTheAxisOnThePrincipalPoint) {
  for (const CameraIntrinsics& camera : {kPinhole, kDistorted}) {
    const auto pixel = ProjectToPixel(camera, {0.0, 0.0, 3.0});
    ASSERT_TRUE(pixel);
    EXPECT_EQ(*pixel, glm::dvec2(319.5, 239.5));
    const auto direction = DirectionFromPixel(camera, {319.5, 239.5});
    ASSERT_TRUE(direction);
    EXPECT_EQ(*direction, glm::dvec3(0.0, 0.0, 1.0));
  }
}

// Without distortion u = fx X/Z + cx by hand: 500 * 0.4 + 319.5, 510 * (-0.2) + 239.5.
TEST(Lens, ProjectsAsAPinholeWithoutDistortion) {
  const auto pixel = ProjectToPixel(kPinhole, {0.8, -0.4, 2.0});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, 519.5, 1e-12);
  EXPECT_NEAR(pixel->y, 137.5, 1e-12);
}

// A second implementation of the same published model. 1e-9 px: rounding of some twenty operations
// on numbers up to 1e3.
TEST(Lens, AgreesWithOpenCv) {
  const cv::Matx33d matrix(500.0, 0.0, 319.5, 0.0, 510.0, 239.5, 0.0, 0.0, 1.0);
  const cv::Matx<double, 1, 5> coefficients(kDistorted.distortion.data());
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> offset(-0.6, 0.6);
  std::vector<cv::Point3d> points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(offset(random), offset(random), 1.0);
  std::vector<cv::Point2d> expected;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), matrix, coefficients, expected);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = ProjectToPixel(kDistorted, {points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x, expected[i].x, 1e-9);
    EXPECT_NEAR(pixel->y, expected[i].y, 1e-9);
  }
}

TEST(Lens, RefusesPointsThatAreNotBeforeTheCamera) {
  for (const CameraIntrinsics& camera : {kPinhole, kDistorted}) {
    EXPECT_FALSE(ProjectToPixel(camera, {0.0, 0.0, -1.0}));
    EXPECT_FALSE(ProjectToPixel(camera, {1.0, 0.0, 0.0}));
    EXPECT_FALSE(ProjectToPixel(camera, {0.0, 0.0, std::nan("")}));
    EXPECT_FALSE(ProjectToPixel(camera, {std::nan(""), 0.0, 1.0}));
    EXPECT_FALSE(DirectionFromPixel(camera, {std::nan(""), 0.0}));
  }
}

TEST(Lens, RefusesImpossibleCamerasByFieldName) {
  CameraIntrinsics camera = kPinhole;
  camera.fx_px = 0.0;
  try {
    Lens{camera};
    FAIL() << "a focal length of 0 was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("fx_px"), std::string::npos) << error.what();
  }
  camera = kPinhole;
  camera.distortion[1] = std::nan("");
  EXPECT_THROW(Lens{camera}, std::invalid_argument);
}

// 1 + 3 k1 r^2 = 0 at r = 1 for k1 = -1/3; k1 = +1/3 never folds.
TEST(Lens, KnowsWhereTheDistortionFolds) {
  CameraIntrinsics camera = kPinhole;
  camera.distortion = {-1.0 / 3.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_NEAR(Lens(camera).ValidRadius(), 1.0, 1e-12);
  camera.distortion = {1.0 / 3.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_GT(Lens(camera).ValidRadius(), 1e4);
  EXPECT_TRUE(std::isinf(Lens(kPinhole).ValidRadius()));
}

TEST(UndistortedCover, IsTheSameCameraWithoutDistortion) {
  EXPECT_EQ(UndistortedCover(kPinhole), kPinhole);
}

// Every pixel's area lies inside the cover, with a pixel to spare; and the cover is the smallest:
// it shrinks by no more than the two pixels that rounding to the grid may add on a side.
TEST(UndistortedCover, HoldsEveryDirectionAndLittleMore) {
  for (const double sign : {-1.0, 1.0}) {
    CameraIntrinsics camera = kDistorted;
    camera.width_px = 320;
    camera.height_px = 240;
    camera.distortion = {sign * 0.15, sign * 0.02, 0.002, -0.003, 0.0};
    const CameraIntrinsics cover = UndistortedCover(camera);
    EXPECT_FALSE(cover.HasDistortion());
    EXPECT_EQ(cover.fx_px, camera.fx_px);
    EXPECT_EQ(cover.fy_px, camera.fy_px);
    glm::dvec2 lower(1e9);
    glm::dvec2 upper(-1e9);
    for (double v = -0.5; v <= camera.height_px - 0.5; v += 0.5) {
      for (double u = -0.5; u <= camera.width_px - 0.5; u += 0.5) {
        const auto direction = DirectionFromPixel(camera, {u, v});
        ASSERT_TRUE(direction);
        const auto pixel = ProjectToPixel(cover, *direction);
        ASSERT_TRUE(pixel);
        lower = glm::min(lower, *pixel);
        upper = glm::max(upper, *pixel);
      }
    }
    for (const double margin : {lower.x + 0.5,
                                lower.y + 0.5,
                                cover.width_px - 0.5 - upper.x,
                                cover.height_px - 0.5 - upper.y}) {
      EXPECT_GE(margin, 1.0);
      EXPECT_LE(margin, 2.0 + 1e-9);
    }
  }
}

}  // namespace
}  // namespace pleinair::lens_test

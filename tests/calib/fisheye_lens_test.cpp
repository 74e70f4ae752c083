#include "calib/fisheye_lens.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <opencv2/calib3d.hpp>

#include "sunmodel/angles.h"

namespace pleinair::fisheye_lens_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::array<FisheyeModel, 3> kIdealModels{
    FisheyeModel::kEquidistant, FisheyeModel::kEquisolid, FisheyeModel::kStereographic};

FisheyeIntrinsics Calibrated() {
  FisheyeIntrinsics lens;
  lens.model = FisheyeModel::kOpenCv;
  lens.width_px = 1032;
  lens.height_px = 778;
  lens.fx_px = 338.0;
  lens.fy_px = 339.5;
  lens.cx_px = 543.9;
  lens.cy_px = 377.6;
  lens.distortion = {-0.031, 0.012, -0.006, 0.0009};
  lens.max_angle_rad = RadFromDeg(100.0);
  return lens;
}

glm::dvec3 Direction(double angle_rad, double azimuth_rad) {
  return {std::sin(angle_rad) * std::cos(azimuth_rad),
          std::sin(angle_rad) * std::sin(azimuth_rad),
          std::cos(angle_rad)};
}

// The definitions at 60 and 90 degrees from the axis: r / f = theta, 2 sin(theta/2), 2
// tan(theta/2).
TEST(FisheyeLens, FollowsItsDefinition) {
  FisheyeIntrinsics lens;
  lens.width_px = lens.height_px = 101;
  lens.fx_px = lens.fy_px = 100.0;
  lens.cx_px = lens.cy_px = 50.0;
  const std::array<double, 3> at_60{kPi / 3.0, 1.0, 2.0 / std::sqrt(3.0)};
  const std::array<double, 3> at_90{kPi / 2.0, std::sqrt(2.0), 2.0};
  for (std::size_t i = 0; i < kIdealModels.size(); ++i) {
    lens.model = kIdealModels[i];
    const FisheyeLens fisheye(lens);
    const auto right = fisheye.ProjectToPixel(7.0 * Direction(kPi / 3.0, 0.0));
    ASSERT_TRUE(right);
    EXPECT_NEAR(right->x, 50.0 + 100.0 * at_60[i], 1e-9);
    EXPECT_NEAR(right->y, 50.0, 1e-9);
    const auto down = fisheye.ProjectToPixel(Direction(kPi / 2.0, kPi / 2.0));
    ASSERT_TRUE(down);
    EXPECT_NEAR(down->x, 50.0, 1e-9);
    EXPECT_NEAR(down->y, 50.0 + 100.0 * at_90[i], 1e-9);
    EXPECT_EQ(fisheye.ProjectToPixel({0.0, 0.0, 3.0}), glm::dvec2(50.0));
  }
}

// OpenCV's own projection, before the camera (it knows no other directions).
TEST(FisheyeLens, AgreesWithOpenCv) {
  const FisheyeIntrinsics lens = Calibrated();
  const FisheyeLens fisheye(lens);
  std::vector<cv::Vec3d> points;
  for (double angle = 0.05; angle < 1.55; angle += 0.05) {
    const glm::dvec3 direction = Direction(angle, 2.3 * angle);
    points.emplace_back(direction.x, direction.y, direction.z);
  }
  const cv::Matx33d camera(lens.fx_px, 0, lens.cx_px, 0, lens.fy_px, lens.cy_px, 0, 0, 1);
  const auto& k = lens.distortion;
  std::vector<cv::Vec2d> expected;
  cv::fisheye::projectPoints(points,
                             expected,
                             cv::Vec3d(0, 0, 0),
                             cv::Vec3d(0, 0, 0),
                             camera,
                             cv::Vec4d(k[0], k[1], k[2], k[3]));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = fisheye.ProjectToPixel({points[i][0], points[i][1], points[i][2]});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x, expected[i][0], 1e-8);
    EXPECT_NEAR(pixel->y, expected[i][1], 1e-8);
  }
}

// A pixel's corners span its solid angle: Girard's excess of the spherical quadrilateral, by the
// two triangles' formula of van Oosterom and Strackee. Great circles for edges instead of the
// pixel's own cost about (pixel / f)^2.
TEST(FisheyeLens, GivesThePixelsSolidAngle) {
  const auto triangle = [](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return std::abs(2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                                     1.0 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a)));
  };
  std::vector<FisheyeIntrinsics> lenses{Calibrated()};
  for (const FisheyeModel model : kIdealModels) {
    lenses.push_back(CentredFisheye(model, RadFromDeg(200.0), 400, 400));
  }
  for (const FisheyeIntrinsics& intrinsics : lenses) {
    const FisheyeLens lens(intrinsics);
    int checked = 0;
    for (int y = 5; y < intrinsics.height_px; y += 37) {
      for (int x = 3; x < intrinsics.width_px; x += 41) {
        std::array<glm::dvec3, 4> corner;
        bool inside = true;
        for (int i = 0; i < 4; ++i) {
          const auto found = lens.DirectionFromPixel(
              {x + (i == 0 || i == 3 ? -0.5 : 0.5), y + (i < 2 ? -0.5 : 0.5)});
          inside = inside && found.has_value();
          if (found) corner[static_cast<std::size_t>(i)] = *found;
        }
        if (!inside) continue;
        const double expected =
            triangle(corner[0], corner[1], corner[2]) + triangle(corner[0], corner[2], corner[3]);
        EXPECT_NEAR(lens.PixelSolidAngleSr({x, y}), expected, 1e-4 * expected) << x << " " << y;
        ++checked;
      }
    }
    EXPECT_GT(checked, 40);
  }
}

// All pixels whose centres are in the circle add up to the cap, 2 pi (1 - cos(fov/2)): a circle of
// radius 256 px holds pi 256^2 pixel centres to 3e-4.
TEST(FisheyeLens, SolidAnglesAddUpToTheFieldOfView) {
  for (const FisheyeModel model : kIdealModels) {
    for (const double fov_deg : {120.0, 180.0, 220.0}) {
      const FisheyeLens lens(CentredFisheye(model, RadFromDeg(fov_deg), 512, 512));
      double sum = 0.0;
      for (int y = 0; y < 512; ++y) {
        for (int x = 0; x < 512; ++x) sum += lens.PixelSolidAngleSr({x, y});
      }
      const double cap = 2.0 * kPi * (1.0 - std::cos(RadFromDeg(0.5 * fov_deg)));
      EXPECT_NEAR(sum / cap, 1.0, 5e-4) << FisheyeModelName(model) << " " << fov_deg;
    }
  }
}

TEST(FisheyeLens, FillsTheShorterSideWithTheFieldOfView) {
  for (const FisheyeModel model : kIdealModels) {
    const FisheyeLens lens(CentredFisheye(model, RadFromDeg(180.0), 640, 480));
    const auto rim = lens.ProjectToPixel({0.0, -1.0, 0.0});
    ASSERT_TRUE(rim);
    EXPECT_NEAR(rim->x, 319.5, 1e-9);
    EXPECT_NEAR(rim->y, -0.5, 1e-9);
  }
  EXPECT_THROW(CentredFisheye(FisheyeModel::kOpenCv, kPi, 640, 480), std::invalid_argument);
}

TEST(FisheyeLens, KnowsItsModelsByName) {
  for (const char* name : {"equidistant", "equisolid", "stereographic", "opencv"}) {
    const auto model = FisheyeModelFromName(name);
    ASSERT_TRUE(model);
    EXPECT_STREQ(FisheyeModelName(*model), name);
  }
  EXPECT_FALSE(FisheyeModelFromName("orthographic"));
}

}  // namespace
}  // namespace pleinair::fisheye_lens_test

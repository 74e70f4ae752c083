#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/fisheye_lens.h"
#include "sunmodel/angles.h"

namespace pleinair::fisheye_lens_hard_cases_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

FisheyeIntrinsics Make(FisheyeModel model, double max_angle_deg) {
  FisheyeIntrinsics lens;
  lens.model = model;
  lens.width_px = 1280;
  lens.height_px = 960;
  lens.fx_px = 300.0;
  lens.fy_px = 310.0;
  lens.cx_px = 651.25;
  lens.cy_px = 470.5;
  lens.max_angle_rad = RadFromDeg(max_angle_deg);
  return lens;
}

glm::dvec3 Direction(double angle_rad, double azimuth_rad) {
  return {std::sin(angle_rad) * std::cos(azimuth_rad),
          std::sin(angle_rad) * std::sin(azimuth_rad),
          std::cos(angle_rad)};
}

// Every model, to 90 degrees and beyond, up to the rim itself: pixel -> direction -> pixel is the
// identity to 1e-6 px, and so is direction -> pixel -> direction wherever a pixel resolves
// directions. Random distortions, folding and not.
TEST(FisheyeLensHardCases, RoundTripInsideTheValidity) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int folding = 0;
  int beyond_90 = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const auto model = static_cast<FisheyeModel>(trial % 4);
    FisheyeIntrinsics intrinsics = Make(model, 20.0 + 160.0 * unit(random));
    if (model == FisheyeModel::kOpenCv) {
      for (double& k : intrinsics.distortion) k = 0.1 * (2.0 * unit(random) - 1.0);
    }
    const FisheyeLens lens(intrinsics);
    folding += lens.MaxAngleRad() < 0.99 * intrinsics.max_angle_rad ? 1 : 0;
    for (int i = 0; i < 50; ++i) {
      // The last ones on the rim and within rounding of it.
      const double share = i < 40 ? unit(random) : 1.0 - std::pow(10.0, -2 - (i - 40));
      const double azimuth = 2.0 * kPi * unit(random);
      const double angle = (i == 49 ? 1.0 : share) * lens.MaxAngleRad();
      beyond_90 += angle > 0.5 * kPi ? 1 : 0;
      const auto pixel = lens.ProjectToPixel(Direction(angle, azimuth));
      ASSERT_TRUE(pixel) << FisheyeModelName(model) << " " << angle << " of " << lens.MaxAngleRad();
      const auto direction = lens.DirectionFromPixel(*pixel);
      ASSERT_TRUE(direction);
      EXPECT_NEAR(glm::length(*direction), 1.0, 1e-14);
      const auto again = lens.ProjectToPixel(3.0 * *direction);
      ASSERT_TRUE(again);
      EXPECT_LT(glm::distance(*again, *pixel), 1e-6);
      if (share < 0.9) {
        EXPECT_LT(glm::distance(*direction, Direction(angle, azimuth)), 1e-9);
      }
    }
  }
  EXPECT_GT(folding, 20);
  EXPECT_GT(beyond_90, 4000);
}

TEST(FisheyeLensHardCases, RefuseWhatIsOutsideTheValidity) {
  for (int m = 0; m < 4; ++m) {
    const FisheyeIntrinsics intrinsics = Make(static_cast<FisheyeModel>(m), 95.0);
    const FisheyeLens lens(intrinsics);
    EXPECT_NEAR(lens.MaxAngleRad(), RadFromDeg(95.0), 1e-15);
    EXPECT_TRUE(lens.ProjectToPixel(Direction(RadFromDeg(94.999), 1.0)));
    EXPECT_FALSE(lens.ProjectToPixel(Direction(RadFromDeg(95.001), 1.0)));
    EXPECT_FALSE(lens.ProjectToPixel({0.0, 0.0, -1.0}));
    EXPECT_FALSE(lens.ProjectToPixel({0.0, 0.0, 0.0}));
    EXPECT_FALSE(lens.ProjectToPixel({kNaN, 0.0, 1.0}));
    EXPECT_FALSE(lens.ProjectToPixel({0.0, 0.0, kNaN}));
    const auto rim = lens.ProjectToPixel(Direction(RadFromDeg(95.0), 0.0));
    ASSERT_TRUE(rim);
    EXPECT_TRUE(lens.DirectionFromPixel({rim->x - 1e-6, rim->y}));
    EXPECT_FALSE(lens.DirectionFromPixel({rim->x + 1e-6, rim->y}));
    EXPECT_FALSE(lens.DirectionFromPixel({kNaN, 0.0}));
    EXPECT_FALSE(lens.DirectionFromPixel({1e300, 1e300}));
    EXPECT_EQ(lens.PixelSolidAngleSr({rim->x + 1.0, rim->y}), 0.0);
  }
}

// theta (1 + k1 theta^2) turns back at theta = 1 / sqrt(-3 k1).
TEST(FisheyeLensHardCases, StopWhereTheDistortionFolds) {
  FisheyeIntrinsics intrinsics = Make(FisheyeModel::kOpenCv, 120.0);
  intrinsics.distortion = {-1.0 / 3.0, 0.0, 0.0, 0.0};
  const FisheyeLens lens(intrinsics);
  EXPECT_NEAR(lens.MaxAngleRad(), 1.0, 1e-12);
  EXPECT_TRUE(lens.ProjectToPixel(Direction(0.999999, 0.0)));
  EXPECT_FALSE(lens.ProjectToPixel(Direction(1.000001, 0.0)));
  for (double x = 0.0; x < 1280.0; x += 1.0) {
    const double solid_angle = lens.PixelSolidAngleSr({x, 470.0});
    EXPECT_TRUE(std::isfinite(solid_angle) && solid_angle >= 0.0) << x;
  }
}

// The entire sphere: straight backwards is refused, all else has its pixel.
TEST(FisheyeLensHardCases, SeeNearlyTheWholeSphere) {
  for (const FisheyeModel model :
       {FisheyeModel::kEquidistant, FisheyeModel::kEquisolid, FisheyeModel::kStereographic}) {
    const FisheyeLens lens(CentredFisheye(model, 2.0 * kPi, 100, 100));
    EXPECT_EQ(lens.MaxAngleRad(), FisheyeLens::kLargestAngleRad);
    EXPECT_FALSE(lens.ProjectToPixel({0.0, 0.0, -1.0}));
    const glm::dvec3 nearly = Direction(kPi - 1.1e-3, 2.0);
    const auto pixel = lens.ProjectToPixel(nearly);
    ASSERT_TRUE(pixel);
    const auto direction = lens.DirectionFromPixel(*pixel);
    ASSERT_TRUE(direction);
    EXPECT_LT(glm::distance(*direction, nearly), 1e-9);
  }
}

TEST(FisheyeLensHardCases, RefuseImpossibleLensesByFieldName) {
  const auto refusal = [](const FisheyeIntrinsics& intrinsics) -> std::string {
    try {
      FisheyeLens{intrinsics};
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  const FisheyeIntrinsics good = Make(FisheyeModel::kOpenCv, 90.0);
  EXPECT_EQ(refusal(good), "accepted");
  FisheyeIntrinsics bad = good;
  bad.width_px = 0;
  EXPECT_EQ(refusal(bad).rfind("width_px", 0), 0u);
  bad = good;
  bad.fy_px = -1.0;
  EXPECT_EQ(refusal(bad).rfind("fy_px", 0), 0u);
  bad = good;
  bad.cx_px = kNaN;
  EXPECT_EQ(refusal(bad).rfind("cx_px", 0), 0u);
  bad = good;
  bad.max_angle_rad = 0.0;
  EXPECT_EQ(refusal(bad).rfind("max_angle_rad", 0), 0u);
  bad = good;
  bad.distortion[2] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(bad).rfind("distortion", 0), 0u);
  bad = Make(FisheyeModel::kEquisolid, 90.0);
  bad.distortion[0] = 0.1;
  EXPECT_EQ(refusal(bad).rfind("distortion", 0), 0u);
}

}  // namespace
}  // namespace pleinair::fisheye_lens_hard_cases_test

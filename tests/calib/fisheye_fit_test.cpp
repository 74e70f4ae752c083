#include "calib/fisheye_fit.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/image_io.h"
#include "sunmodel/angles.h"

namespace pleinair::fisheye_fit_test {
namespace {

constexpr BoardSize kBoard{8, 6};

FisheyeIntrinsics TrueLens() {
  FisheyeIntrinsics lens;
  lens.model = FisheyeModel::kOpenCv;
  lens.width_px = 1000;
  lens.height_px = 800;
  lens.fx_px = 320.0;
  lens.fy_px = 322.0;
  lens.cx_px = 505.0;
  lens.cy_px = 390.0;
  lens.distortion = {-0.02, 0.004, -0.002, 0.0003};
  lens.max_angle_rad = RadFromDeg(110.0);
  return lens;
}

// Boards around the camera, tilted differently, with corners found to `noise_px`.
std::vector<BoardPicture> Boards(double noise_px, int count) {
  const FisheyeLens lens(TrueLens());
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, noise_px);
  std::vector<BoardPicture> boards;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2.4 * i;
    const double angle = 0.15 + 0.75 * (i % 5) / 4.0;
    glm::dmat4 pose = glm::rotate(glm::dmat4(1.0), azimuth, glm::dvec3(0, 0, 1));
    pose = glm::rotate(pose, angle, glm::dvec3(0, 1, 0));
    pose = glm::translate(pose, glm::dvec3(0, 0, 7.0 + i % 3));
    pose = glm::rotate(pose, 0.5 * std::sin(1.7 * i), glm::dvec3(1, 0, 0));
    pose = glm::rotate(pose, 0.5 * std::cos(2.9 * i), glm::dvec3(0, 1, 0));
    BoardPicture& board = boards.emplace_back();
    board.name = "picture " + std::to_string(i);
    for (int row = 0; row < kBoard.rows; ++row) {
      for (int column = 0; column < kBoard.columns; ++column) {
        const glm::dvec4 point = pose * glm::dvec4(column - 3.5, row - 2.5, 0.0, 1.0);
        const auto pixel = lens.ProjectToPixel(glm::dvec3(point));
        EXPECT_TRUE(pixel);
        board.corners_px.push_back(*pixel + glm::dvec2(normal(random), normal(random)));
      }
    }
  }
  return boards;
}

// The largest distance in the picture between where the two lenses see a direction, up to `angle`.
double WorstDifferencePx(const FisheyeIntrinsics& a, const FisheyeIntrinsics& b, double angle_rad) {
  const FisheyeLens lens_a(a);
  const FisheyeLens lens_b(b);
  double worst = 0.0;
  for (double angle = 0.0; angle <= angle_rad; angle += 0.05) {
    for (double azimuth = 0.0; azimuth < 6.2; azimuth += 0.2) {
      const glm::dvec3 direction(std::sin(angle) * std::cos(azimuth),
                                 std::sin(angle) * std::sin(azimuth),
                                 std::cos(angle));
      worst = std::max(worst,
                       glm::distance(lens_a.ProjectToPixel(direction).value(),
                                     lens_b.ProjectToPixel(direction).value()));
    }
  }
  return worst;
}

// Exact corners give the lens back, wherever boards were seen (the distortion's coefficients
// themselves trade against each other).
TEST(FisheyeFit, FindsTheLensThatMadeTheCorners) {
  const FisheyeFit fit = FitFisheyeLens(Boards(0.0, 15), kBoard, 1000, 800);
  EXPECT_TRUE(fit.rejected.empty());
  EXPECT_LT(fit.rms_px, 1e-3);
  EXPECT_GT(fit.covered_angle_rad, RadFromDeg(60.0));
  EXPECT_LT(WorstDifferencePx(fit.lens, TrueLens(), fit.covered_angle_rad), 0.05);
}

// Noise of 0.2 px a coordinate: the residual is its length, 0.28; the lens is known ten times
// better than one corner where boards are, twice as badly at their edge.
TEST(FisheyeFit, StandsNoise) {
  const FisheyeFit fit = FitFisheyeLens(Boards(0.2, 15), kBoard, 1000, 800);
  EXPECT_NEAR(fit.rms_px, 0.28, 0.03);
  EXPECT_LT(WorstDifferencePx(fit.lens, TrueLens(), 0.7 * fit.covered_angle_rad), 0.75);
}

TEST(FisheyeFitHardCases, NamesThePicturesThatDoNotFit) {
  std::vector<BoardPicture> boards = Boards(0.1, 15);
  // Two corners mixed up; a board pressed flat on one side; noise.
  std::swap(boards[3].corners_px[9], boards[3].corners_px[22]);
  for (std::size_t i = 0; i < 48; ++i) {
    if (i % 8 > 4) boards[7].corners_px[i].x += 12.0;
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(0.0, 800.0);
  for (glm::dvec2& corner : boards[12].corners_px) corner = {anywhere(random), anywhere(random)};
  const FisheyeFit fit = FitFisheyeLens(boards, kBoard, 1000, 800);
  std::vector<std::string> names;
  for (const RejectedPicture& picture : fit.rejected) {
    names.push_back(picture.name);
    EXPECT_FALSE(picture.reason.empty());
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("picture 3", "picture 7", "picture 12"));
  EXPECT_EQ(fit.fitted.size(), 12u);
  EXPECT_NEAR(fit.rms_px, 0.14, 0.02);
}

TEST(FisheyeFitHardCases, ReportsWhyNothingFits) {
  std::vector<BoardPicture> boards = Boards(0.1, 2);
  try {
    FitFisheyeLens(boards, kBoard, 1000, 800);
    FAIL() << "two pictures were accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("3 pictures or more"));
  }
  boards = Boards(0.1, 6);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(0.0, 800.0);
  for (BoardPicture& board : boards) {
    for (glm::dvec2& corner : board.corners_px) corner = {anywhere(random), anywhere(random)};
  }
  EXPECT_THROW(FitFisheyeLens(boards, kBoard, 1000, 800), std::runtime_error);
  boards[2].corners_px.pop_back();
  EXPECT_THROW(FitFisheyeLens(boards, kBoard, 1000, 800), std::invalid_argument);
  EXPECT_THROW(FitFisheyeLens({}, {8, 2}, 1000, 800), std::invalid_argument);
  EXPECT_THROW(FitFisheyeLens({}, kBoard, 1000, 0), std::invalid_argument);
  EXPECT_FALSE(FindBoardCorners(Gray8Image(64, 64, 128), kBoard));
  EXPECT_FALSE(FindBoardCorners(Gray8Image(), kBoard));
}

// Fifteen real pictures; another tool (Scaramuzza's model) found the centre at 543.99, 377.65. All
// are found, and fit to what corners in JPEGs of strongly bent boards are good for.
TEST(FisheyeFit, CalibratesARealLens) {
  const std::filesystem::path folder =
      std::filesystem::path(PLEINAIR_SHARED_DIR) / "data/lens_calibration/fisheye_board";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no pictures in " << folder;
  std::vector<BoardPicture> boards;
  for (int i = 1; i <= 15; ++i) {
    const std::string name = "Fisheye1_" + std::to_string(i) + ".jpg";
    const auto corners = FindBoardCorners(ReadMaskImage(folder / name), kBoard);
    ASSERT_TRUE(corners) << name;
    boards.push_back({name, *corners});
  }
  const FisheyeFit fit = FitFisheyeLens(boards, kBoard, 1032, 778);
  EXPECT_TRUE(fit.rejected.empty()) << fit.rejected[0].name << ": " << fit.rejected[0].reason;
  EXPECT_LT(fit.rms_px, 0.5);
  EXPECT_NEAR(fit.lens.cx_px, 543.99, 1.0);
  EXPECT_NEAR(fit.lens.cy_px, 377.65, 1.0);
  EXPECT_GT(fit.covered_angle_rad, RadFromDeg(80.0));

  // The fourth picture's board mirrored: found by name.
  std::reverse(boards[3].corners_px.begin(), boards[3].corners_px.begin() + 8);
  const FisheyeFit without = FitFisheyeLens(boards, kBoard, 1032, 778);
  ASSERT_EQ(without.rejected.size(), 1u);
  EXPECT_EQ(without.rejected[0].name, "Fisheye1_4.jpg");
}

// The result of OpenCV's fit with the wrong board size: fx 904, fy 502, off by 5 px.
TEST(FisheyeFit, IsInDoubtWhereItMissesOrPixelsAreNotSquare) {
  FisheyeFit fit;
  fit.lens.fx_px = 337.0;
  fit.lens.fy_px = 336.0;
  fit.rms_px = 0.39;
  EXPECT_EQ(DoubtAbout(fit), "");
  fit.rms_px = 1.01;
  EXPECT_NE(DoubtAbout(fit).find("missed by 1.01 px"), std::string::npos);
  fit.rms_px = std::nan("");
  EXPECT_NE(DoubtAbout(fit), "");
  fit.rms_px = 0.39;
  fit.lens.fx_px = 904.0;
  fit.lens.fy_px = 502.0;
  EXPECT_NE(DoubtAbout(fit).find("fx is 904.00 px and fy 502.00 px"), std::string::npos);
  fit.lens.fx_px = 0.96 * fit.lens.fy_px;
  EXPECT_NE(DoubtAbout(fit), "");
}

}  // namespace
}  // namespace pleinair::fisheye_fit_test

#include "calib/lens_fit.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/internal/opencv_types.h"
#include "calib/lens.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"
#include "tests/calib/true_fisheye.h"

namespace pleinair::lens_fit_test {
namespace {

constexpr BoardSize kBoard{8, 6};

// Boards around the camera up to `farthest_rad` from the axis, tilted differently, with corners
// found to `noise_px`.
template <typename AnyOneLens>
std::vector<BoardPicture> BoardsSeenBy(const AnyOneLens& lens,
                                       double farthest_rad,
                                       double noise_px,
                                       int count) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, noise_px);
  std::vector<BoardPicture> boards;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2.4 * i;
    const double angle = farthest_rad * (0.2 + 0.8 * (i % 5) / 4.0);
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
        board.corners.push_back(
            {{column, row}, *pixel + glm::dvec2(normal(random), normal(random))});
      }
    }
  }
  return boards;
}

std::vector<BoardPicture> Boards(double noise_px, int count) {
  return BoardsSeenBy(FisheyeLens(TrueFisheye()), 0.9, noise_px, count);
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
TEST(LensFit, FindsTheLensThatMadeTheCorners) {
  const LensFit fit = FitLens(Boards(0.0, 15), LensModel::kFisheye, 1000, 800);
  EXPECT_TRUE(fit.rejected.empty());
  EXPECT_LT(fit.rms_px, 1e-3);
  EXPECT_GT(fit.covered_angle_rad, RadFromDeg(60.0));
  EXPECT_LT(WorstDifferencePx(
                std::get<FisheyeIntrinsics>(fit.lens), TrueFisheye(), fit.covered_angle_rad),
            0.05);
}

// Noise of 0.2 px a coordinate: the residual is its length, 0.28; the lens is known ten times
// better than one corner where boards are, twice as badly at their edge.
TEST(LensFit, StandsNoise) {
  const LensFit fit = FitLens(Boards(0.2, 15), LensModel::kFisheye, 1000, 800);
  EXPECT_NEAR(fit.rms_px, 0.28, 0.03);
  EXPECT_LT(WorstDifferencePx(
                std::get<FisheyeIntrinsics>(fit.lens), TrueFisheye(), 0.7 * fit.covered_angle_rad),
            0.75);
}

TEST(LensFitHardCases, NamesThePicturesThatDoNotFit) {
  std::vector<BoardPicture> boards = Boards(0.1, 15);
  // Two corners mixed up; a board pressed flat on one side; noise.
  std::swap(boards[3].corners[9].pixel, boards[3].corners[22].pixel);
  for (std::size_t i = 0; i < 48; ++i) {
    if (i % 8 > 4) boards[7].corners[i].pixel.x += 12.0;
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(0.0, 800.0);
  for (BoardCorner& corner : boards[12].corners) {
    corner.pixel = {anywhere(random), anywhere(random)};
  }
  const LensFit fit = FitLens(boards, LensModel::kFisheye, 1000, 800);
  std::vector<std::string> names;
  for (const RejectedPicture& picture : fit.rejected) {
    names.push_back(picture.name);
    EXPECT_FALSE(picture.reason.empty());
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("picture 3", "picture 7", "picture 12"));
  EXPECT_EQ(fit.fitted.size(), 12u);
  EXPECT_NEAR(fit.rms_px, 0.14, 0.02);
}

// A person knows better: the picture that is left out else stays, and the others are as before.
TEST(LensFitHardCases, APictureThatIsAlwaysUsedStays) {
  std::vector<BoardPicture> boards = Boards(0.1, 15);
  for (const std::size_t i : {3u, 7u}) boards[i].corners[20].pixel += glm::dvec2(16.0, 0.0);
  boards[3].is_always_used = true;
  const LensFit fit = FitLens(boards, LensModel::kFisheye, 1000, 800);
  ASSERT_EQ(fit.rejected.size(), 1u);
  EXPECT_EQ(fit.rejected[0].name, "picture 7");
  ASSERT_EQ(fit.fitted.size(), 14u);
  // One corner of 48 by 16 px.
  EXPECT_NEAR(fit.fitted[3].rms_px, 16.0 / std::sqrt(48.0), 0.3);

  boards[3].edge_width_px = 40.0;
  boards[7].edge_width_px = 40.0;
  const std::vector<RejectedPicture> blurred = TakeOutBlurred(boards);
  ASSERT_EQ(blurred.size(), 1u);
  EXPECT_EQ(blurred[0].name, "picture 7");
}

TEST(LensFitHardCases, ReportsWhyNothingFits) {
  std::vector<BoardPicture> boards = Boards(0.1, 2);
  try {
    FitLens(boards, LensModel::kFisheye, 1000, 800);
    FAIL() << "two pictures were accepted";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("3 pictures or more"));
  }
  boards = Boards(0.1, 6);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(0.0, 800.0);
  for (BoardPicture& board : boards) {
    for (BoardCorner& corner : board.corners) {
      corner.pixel = {anywhere(random), anywhere(random)};
    }
  }
  EXPECT_THROW(FitLens(boards, LensModel::kFisheye, 1000, 800), std::runtime_error);
  boards[2].corners.resize(5);
  EXPECT_THROW(FitLens(boards, LensModel::kFisheye, 1000, 800), std::invalid_argument);
  EXPECT_THROW(FitLens({}, LensModel::kPinhole, 1000, 0), std::invalid_argument);
  EXPECT_THROW(FindBoardCorners(Gray8Image(64, 64, 128), {{8, 2}, {}}), std::invalid_argument);
  EXPECT_FALSE(FindBoardCorners(Gray8Image(64, 64, 128), {kBoard, {}}));
  EXPECT_FALSE(FindBoardCorners(Gray8Image(), {kBoard, {}}));
}

// A pinhole lens with strong distortion is found as one: a fish-eye fits it no better.
TEST(LensFit, ChoosesThePinholeThatMadeTheCorners) {
  CameraIntrinsics camera;
  camera.width_px = 1280;
  camera.height_px = 960;
  camera.fx_px = 900.0;
  camera.fy_px = 902.0;
  camera.cx_px = 645.0;
  camera.cy_px = 470.0;
  camera.distortion = {-0.25, 0.08, 0.0005, -0.0008, 0.0};
  const LensChoice choice =
      ChooseLens(BoardsSeenBy(Lens(camera), 0.25, 0.2, 15), camera.width_px, camera.height_px);
  ASSERT_EQ(choice.fit.Model(), LensModel::kPinhole);
  ASSERT_TRUE(choice.pinhole.held_out);
  EXPECT_NEAR(choice.pinhole.held_out->rms_px, 0.28, 0.05);
  EXPECT_TRUE(choice.fisheye.held_out || !choice.fisheye.failure.empty());
  EXPECT_NEAR(choice.fit.rms_px, 0.28, 0.03);
  // 1 %, and what its own deviation allows.
  EXPECT_NEAR(choice.fit.FxPx(), camera.fx_px, 9.0);
  EXPECT_NEAR(choice.fit.FxPx(), camera.fx_px, 4.0 * choice.pinhole.held_out->focal_sigma_px);
}

TEST(LensFit, ChoosesTheFisheyeThatMadeTheCorners) {
  const LensChoice choice = ChooseLens(Boards(0.2, 15), 1000, 800);
  ASSERT_EQ(choice.fit.Model(), LensModel::kFisheye);
  EXPECT_NEAR(choice.fit.FxPx(), TrueFisheye().fx_px, 0.01 * TrueFisheye().fx_px);
  ASSERT_TRUE(choice.fisheye.held_out);
  EXPECT_LT(choice.fisheye.held_out->rms_px, 0.35);
}

Gray8Image Copy(const cv::Mat& view) {
  Gray8Image picture(view.cols, view.rows);
  view.copyTo(MatOf(picture));
  return picture;
}

// Fifteen real pictures. Another tool (Scaramuzza's model) found the centre at 543.99, 377.65, and
// r = 337.72 px for small angles, stretched by 1.0033 along x.
class RealBoards : public testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path folder =
        std::filesystem::path(PLEINAIR_SHARED_DIR) / "data/lens_calibration/fisheye_board";
    if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no pictures in " << folder;
    for (int i = 1; i <= 15; ++i) {
      pictures_.push_back(ReadMaskImage(folder / ("Fisheye1_" + std::to_string(i) + ".jpg")));
    }
  }

  // As the command does: boards found, blurred ones taken out, a lens chosen.
  struct Outcome {
    LensFit fit;
    std::vector<std::string> left_out;
  };
  Outcome Calibrate() const {
    std::vector<BoardPicture> boards;
    Outcome outcome;
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      const std::string name = "picture " + std::to_string(i + 1);
      const auto corners = FindBoardCorners(pictures_[i], {kBoard, {}});
      if (corners) {
        boards.push_back({name, *corners, BoardEdgeWidthPx(pictures_[i], {kBoard, {}}, *corners)});
      } else {
        outcome.left_out.push_back(name);
      }
    }
    for (const RejectedPicture& picture : TakeOutBlurred(boards)) {
      outcome.left_out.push_back(picture.name);
    }
    outcome.fit = ChooseLens(boards, 1032, 778).fit;
    for (const RejectedPicture& picture : outcome.fit.rejected) {
      outcome.left_out.push_back(picture.name);
    }
    return outcome;
  }

  std::vector<Gray8Image> pictures_;
};

TEST_F(RealBoards, GiveTheReferencesLens) {
  const Outcome outcome = Calibrate();
  EXPECT_THAT(outcome.left_out, testing::IsEmpty());
  ASSERT_EQ(outcome.fit.Model(), LensModel::kFisheye);
  const FisheyeIntrinsics lens = std::get<FisheyeIntrinsics>(outcome.fit.lens);
  EXPECT_LT(outcome.fit.rms_px, 0.5);
  EXPECT_NEAR(lens.fx_px, 1.0033 * 337.72, 0.01 * 337.72);
  EXPECT_NEAR(lens.fy_px, 337.72, 0.01 * 337.72);
  EXPECT_NEAR(lens.cx_px, 543.99, 1.0);
  EXPECT_NEAR(lens.cy_px, 377.65, 1.0);
  EXPECT_GT(outcome.fit.covered_angle_rad, RadFromDeg(80.0));
}

// Spoiled one by one and all together: blurred, half of the board cropped, something else, the
// board mirrored.
TEST_F(RealBoards, SpoiledPicturesAreNamed) {
  const std::vector<Gray8Image> good = pictures_;
  const auto blur = [&] { cv::GaussianBlur(MatOf(good[1]), MatOf(pictures_[1]), {}, 4.0); };
  const auto crop = [&] {
    pictures_[5] = good[5];
    const auto corners = FindBoardCorners(good[5], {kBoard, {}});
    ASSERT_TRUE(corners);
    const int middle = static_cast<int>((*corners)[20].pixel.x);
    MatOf(pictures_[5])(cv::Rect(0, 0, middle, 778)).setTo(90);
  };
  const auto another = [&] {
    cv::Mat noise = MatOf(pictures_[8]);
    cv::randu(noise, 0, 255);
    cv::GaussianBlur(noise, noise, {}, 12.0);
    cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  };
  const auto mirror = [&] {
    cv::Mat flipped;
    cv::flip(MatOf(good[12]), flipped, 1);
    pictures_[12] = Copy(flipped);
  };
  const auto names = [&] {
    const Outcome outcome = Calibrate();
    EXPECT_LT(outcome.fit.rms_px, 0.5);
    EXPECT_NEAR(outcome.fit.FxPx(), 1.0033 * 337.72, 0.01 * 337.72);
    pictures_ = good;
    return outcome.left_out;
  };
  blur();
  EXPECT_THAT(names(), testing::ElementsAre("picture 2"));
  crop();
  EXPECT_THAT(names(), testing::ElementsAre("picture 6"));
  another();
  EXPECT_THAT(names(), testing::ElementsAre("picture 9"));
  mirror();
  EXPECT_THAT(names(), testing::ElementsAre("picture 13"));
  blur();
  crop();
  another();
  mirror();
  EXPECT_THAT(names(),
              testing::UnorderedElementsAre("picture 2", "picture 6", "picture 9", "picture 13"));
}

// Corners of one row the wrong way round.
TEST_F(RealBoards, CornersOnTheWrongSquaresAreNamed) {
  std::vector<BoardPicture> boards;
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    const auto corners = FindBoardCorners(pictures_[i], {kBoard, {}});
    ASSERT_TRUE(corners);
    boards.push_back({std::to_string(i + 1), *corners});
  }
  for (std::size_t i = 0; i < 4; ++i) {
    std::swap(boards[3].corners[i].pixel, boards[3].corners[7 - i].pixel);
  }
  const LensFit fit = FitLens(boards, LensModel::kFisheye, 1032, 778);
  ASSERT_EQ(fit.rejected.size(), 1u);
  EXPECT_EQ(fit.rejected[0].name, "4");
}

// A ChArUco board of 7 x 5 squares drawn by OpenCV and seen in perspective, partly out of the
// picture in some: its corners as they were drawn, to what antialiasing leaves.
TEST(CharucoBoard, IsFoundInParts) {
  const CalibrationBoard board{{6, 4}, CharucoMarkers{}};
  const auto pattern = cv::aruco::CharucoBoard::create(
      7, 5, 1.0f, 0.75f, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50));
  constexpr float kSquarePx = 100.0f;
  cv::Mat drawn;
  pattern->draw({700, 500}, drawn, 0, 1);
  int parts = 0;
  for (int i = 0; i < 6; ++i) {
    const float out = -60.0f * static_cast<float>(i);
    const std::array<cv::Point2f, 4> from{
        cv::Point2f(0, 0), cv::Point2f(700, 0), cv::Point2f(700, 500), cv::Point2f(0, 500)};
    const std::array<cv::Point2f, 4> to{cv::Point2f(60 + out, 40),
                                        cv::Point2f(560 + out, 70),
                                        cv::Point2f(600 + out, 430),
                                        cv::Point2f(30 + out, 400)};
    const cv::Mat seen_from_drawn = cv::getPerspectiveTransform(from.data(), to.data());
    cv::Mat seen;
    cv::warpPerspective(drawn,
                        seen,
                        seen_from_drawn,
                        {640, 480},
                        cv::INTER_AREA,
                        cv::BORDER_CONSTANT,
                        cv::Scalar(255));
    const auto corners = FindBoardCorners(Copy(seen), board);
    ASSERT_TRUE(corners) << corners.error();
    parts += corners->size() < 24 ? 1 : 0;
    for (const BoardCorner& corner : *corners) {
      // Drawn pixels are counted from their corners.
      const float x = kSquarePx * static_cast<float>(corner.place_squares.x + 1.0) - 0.5f;
      const float y = kSquarePx * static_cast<float>(corner.place_squares.y + 1.0) - 0.5f;
      std::vector<cv::Point2f> point{{x, y}};
      cv::perspectiveTransform(point, point, seen_from_drawn);
      EXPECT_LT(glm::distance(corner.pixel, glm::dvec2(point[0].x, point[0].y)), 0.5);
    }
  }
  EXPECT_GE(parts, 2);
  const auto none = FindBoardCorners(Gray8Image(640, 480, 200), board);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error(), testing::HasSubstr("found 0 (0 markers of 4x4_50)"));
  EXPECT_THROW(FindBoardCorners(Gray8Image(640, 480, 200), {{20, 20}, CharucoMarkers{}}),
               std::invalid_argument);
}

// The result of OpenCV's fit with the wrong board size: fx 904, fy 502, off by 5 px.
TEST(LensFit, IsInDoubtWhereItMissesOrPixelsAreNotSquare) {
  LensFit fit;
  CameraIntrinsics& lens = std::get<CameraIntrinsics>(fit.lens);
  lens.fx_px = 337.0;
  lens.fy_px = 336.0;
  fit.rms_px = 0.39;
  EXPECT_EQ(DoubtAbout(fit), "");
  fit.rms_px = 1.01;
  EXPECT_NE(DoubtAbout(fit).find("missed by 1.01 px"), std::string::npos);
  fit.rms_px = std::nan("");
  EXPECT_NE(DoubtAbout(fit), "");
  fit.rms_px = 0.39;
  lens.fx_px = 904.0;
  lens.fy_px = 502.0;
  EXPECT_NE(DoubtAbout(fit).find("fx is 904.00 px and fy 502.00 px"), std::string::npos);
  lens.fx_px = 0.96 * lens.fy_px;
  EXPECT_NE(DoubtAbout(fit), "");
}

}  // namespace
}  // namespace pleinair::lens_fit_test

#include "calib/board_fit.h"

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "calib/lens.h"
#include "sunmodel/angles.h"
#include "tests/calib/true_fisheye.h"

namespace pleinair::board_fit_test {
namespace {

CameraIntrinsics Pinhole() {
  CameraIntrinsics lens;
  lens.width_px = 1000;
  lens.height_px = 800;
  lens.fx_px = 700.0;
  lens.fy_px = 705.0;
  lens.cx_px = 505.0;
  lens.cy_px = 390.0;
  lens.distortion = {-0.1, 0.02, 0.001, -0.001, 0.0};
  return lens;
}

// A tilted board of 8x6, `angle_rad` from the axis.
template <typename OneLens>
BoardPicture BoardSeenBy(const OneLens& lens, double angle_rad) {
  glm::dmat4 pose = glm::rotate(glm::dmat4(1.0), angle_rad, glm::dvec3(0, 1, 0));
  pose = glm::translate(pose, glm::dvec3(0, 0, 12.0));
  pose = glm::rotate(pose, 0.5, glm::normalize(glm::dvec3(1.0, 0.7, 0.2)));
  BoardPicture board;
  for (int i = 0; i < 48; ++i) {
    const int column = i % 8;
    const int row = i / 8;
    const glm::dvec4 point = pose * glm::dvec4(column - 3.5, row - 2.5, 0.0, 1.0);
    board.corners.push_back({{column, row}, lens.ProjectToPixel(glm::dvec3(point)).value()});
  }
  return board;
}

// The pose's six degrees of freedom take up a share of one corner's error of some 6 / 96.
void ExpectTheMovedCorner(const AnyLens& lens, BoardPicture board) {
  const auto exact = FitBoard(lens, board);
  ASSERT_TRUE(exact);
  EXPECT_LT(exact->rms_px, 1e-5);
  const glm::dvec2 off(3.0, -4.0);
  board.corners[19].pixel += off;
  const auto fit = FitBoard(lens, board);
  ASSERT_TRUE(fit);
  ASSERT_EQ(fit->residual_px.size(), 48u);
  EXPECT_NEAR(fit->residual_px[19].x, off.x, 0.7);
  EXPECT_NEAR(fit->residual_px[19].y, off.y, 0.7);
  double sum = 0.0;
  for (std::size_t i = 0; i < 48; ++i) {
    sum += glm::dot(fit->residual_px[i], fit->residual_px[i]);
    if (i == 19) continue;
    EXPECT_LT(glm::length(fit->residual_px[i]), 0.8) << i;
  }
  EXPECT_NEAR(fit->rms_px, std::sqrt(sum / 48.0), 1e-9);
}

TEST(BoardFit, ShowsTheCornerThatWasMoved) {
  ExpectTheMovedCorner(Pinhole(), BoardSeenBy(Lens(Pinhole()), 0.2));
  ExpectTheMovedCorner(TrueFisheye(), BoardSeenBy(FisheyeLens(TrueFisheye()), 0.3));
}

// No plane before the camera holds such a board.
TEST(BoardFit, HoldsPastARightAngleFromTheAxis) {
  ExpectTheMovedCorner(TrueFisheye(), BoardSeenBy(FisheyeLens(TrueFisheye()), RadFromDeg(88.0)));
}

TEST(BoardFit, CornersOnALineHaveNoPose) {
  BoardPicture board = BoardSeenBy(Lens(Pinhole()), 0.2);
  board.corners.resize(8);
  EXPECT_FALSE(FitBoard(Pinhole(), board));
  board.corners.resize(3);
  EXPECT_FALSE(FitBoard(Pinhole(), board));
}

}  // namespace
}  // namespace pleinair::board_fit_test

// Pictures of a chessboard as a pinhole without distortion sees it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "scene/image.h"

namespace pleinair {

// Inner corners 8x6, of 9x7 squares, in six poses; the focal length is 1.09375 widths. `width`: of
// pictures of 4:3.
inline constexpr double kDrawnFocalShare = 1.09375;
inline std::vector<Rgb8Image> DrawnBoards(int width) {
  cv::Mat board(900, 1100, CV_8U, cv::Scalar(255));
  for (int row = 0; row < 7; ++row) {
    for (int column = row % 2; column < 9; column += 2) {
      board(cv::Rect(100 + 100 * column, 100 + 100 * row, 100, 100)).setTo(20);
    }
  }
  const int height = 3 * width / 4;
  const double focal_px = kDrawnFocalShare * width;
  const cv::Matx33d camera(
      focal_px, 0, 0.5 * (width - 1), 0, focal_px, 0.5 * (height - 1), 0, 0, 1);
  std::vector<Rgb8Image> pictures;
  for (int i = 0; i < 6; ++i) {
    cv::Matx33d turn;
    cv::Rodrigues(cv::Vec3d(0.45 * std::cos(1.3 * i), 0.5 * std::sin(1.9 * i), 0.1 * i), turn);
    // The board's plane, in its own pixels about its middle.
    const cv::Vec3d to(40.0 * (i % 3 - 1), 25.0 * (i % 2), 1500.0 + 60.0 * i);
    const cv::Matx33d plane(turn(0, 0),
                            turn(0, 1),
                            to[0],
                            turn(1, 0),
                            turn(1, 1),
                            to[1],
                            turn(2, 0),
                            turn(2, 1),
                            to[2]);
    const cv::Matx33d middle(1, 0, -549.5, 0, 1, -449.5, 0, 0, 1);
    cv::Mat seen;
    cv::warpPerspective(board,
                        seen,
                        cv::Mat(camera * plane * middle),
                        {width, height},
                        cv::INTER_AREA,
                        cv::BORDER_CONSTANT,
                        cv::Scalar(150));
    cv::GaussianBlur(seen, seen, {}, 0.7);
    Rgb8Image& picture = pictures.emplace_back(width, height);
    std::transform(seen.begin<std::uint8_t>(),
                   seen.end<std::uint8_t>(),
                   picture.pixels.begin(),
                   [](std::uint8_t grey) { return glm::u8vec3(grey); });
  }
  return pictures;
}

// Out of focus.
inline Rgb8Image Blurred(Rgb8Image picture, double sigma_px) {
  cv::Mat pixels(picture.height, picture.width, CV_8UC3, picture.pixels.data());
  cv::GaussianBlur(pixels, pixels, {}, sigma_px);
  return picture;
}

}  // namespace pleinair

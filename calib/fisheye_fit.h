// A fish-eye lens from pictures of a flat board.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "calib/fisheye_lens.h"
#include "scene/image.h"

namespace pleinair {

// Inner corners of a chessboard: where four squares meet.
struct BoardSize {
  int columns = 0;
  int rows = 0;

  // Throws std::invalid_argument naming the field and its value: fewer than 3 a side.
  void Validate() const;
  int Count() const { return columns * rows; }
  bool operator==(const BoardSize&) const = default;
};

// "8x6".
std::string TextOf(BoardSize board);

// All inner corners, row by row, to a part of a pixel; none where they are not all found. Safe from
// any thread. Throws as BoardSize::Validate.
std::optional<std::vector<glm::dvec2>> FindBoardCorners(const Gray8Image& picture, BoardSize board);

// How many inner corners the largest chessboard in the picture has, columns >= rows; none where no
// board is found. Parts of a strongly bent board may be missed: the size to try, not a measurement.
std::optional<BoardSize> FindBoardSize(const Gray8Image& picture);

struct BoardPicture {
  std::string name;
  std::vector<glm::dvec2> corners_px;
};

struct FittedPicture {
  std::string name;
  double rms_px = 0.0;
};

struct RejectedPicture {
  std::string name;
  std::string reason;
};

struct FisheyeFit {
  FisheyeIntrinsics lens;  // Model kOpenCv; max_angle_rad to the picture's farthest corner, or
                           // where the distortion folds.
  double rms_px = 0.0;     // Over all corners of the fitted pictures.
  double covered_angle_rad = 0.0;  // The farthest corner of a board from the axis: beyond, the
                                   // lens is extrapolated.
  std::vector<FittedPicture> fitted;
  std::vector<RejectedPicture> rejected;
};

// Least squares over lens and board poses (cv::fisheye::calibrate, no skew). A picture that spoils
// the solution, or fits far worse than the others (kWorstShare times the median, and more than
// kWorstPx), is left out, named, and the rest fitted again; what then fits after all comes back.
//
// Not seen  boards that reach beyond 90 degrees from the axis are left out: OpenCV's fit cannot
// hold
//           them.
// Throws    std::invalid_argument: corners that are not Count() many, a size that is not positive;
//           std::runtime_error where fewer than 3 pictures are left, with what was wrong with the
//           others.
FisheyeFit FitFisheyeLens(std::span<const BoardPicture> pictures,
                          BoardSize board,
                          int width_px,
                          int height_px);

// What is wrong with a fit that no camera with square pixels gives, or that its pictures
// contradict: rms above kLargestCredibleRmsPx, or fx and fy further apart than kLargestPixelAspect.
// Empty where nothing is. Corners of another board size, or of another board, fit like that.
inline constexpr double kLargestCredibleRmsPx = 1.0;
inline constexpr double kLargestPixelAspect = 0.03;  // |fx / fy - 1|
std::string DoubtAbout(const FisheyeFit& fit);

}  // namespace pleinair

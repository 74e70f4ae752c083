// Flat boards that lenses are calibrated with, chessboard or ChArUco, and their corners in
// pictures.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <tl/expected.hpp>

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

// A ChArUco board's markers, in its white squares.
struct CharucoMarkers {
  std::string dictionary = "4x4_50";  // As FindMarkerDictionary.
  double side_share = 0.75;           // Side of a marker over that of a square; 0 to 1.
};

struct CalibrationBoard {
  BoardSize size;
  std::optional<CharucoMarkers> markers;  // None: a plain chessboard.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

struct BoardCorner {
  glm::dvec2 place_squares{0.0};  // On the board, in sides of a square.
  glm::dvec2 pixel{0.0};
};

// The inner corners, to a part of a pixel: of a chessboard all, row by row; of a ChArUco board
// those that are seen, 6 or more and not on one line. Otherwise what is not found, in a few words.
// Safe from any thread. Throws as CalibrationBoard::Validate.
tl::expected<std::vector<BoardCorner>, std::string> FindBoardCorners(const Gray8Image& picture,
                                                                     const CalibrationBoard& board);

// How many inner corners the largest chessboard in the picture has, columns >= rows; none where no
// board is found. Parts of a strongly bent board may be missed: the size to try, not a measurement.
std::optional<BoardSize> FindBoardSize(const Gray8Image& picture);

// How soft the picture is at the board: pixels in which the edges between its squares rise from
// 10 % to 90 % of their height, the median edge; 0 where no edge can be measured.
double BoardEdgeWidthPx(const Gray8Image& picture,
                        const CalibrationBoard& board,
                        const std::vector<BoardCorner>& corners);

struct BoardPicture {
  std::string name;
  std::vector<BoardCorner> corners;
  double edge_width_px = 0.0;  // BoardEdgeWidthPx; 0: not known.
};

struct RejectedPicture {
  std::string name;
  std::string reason;
};

// Takes out of `pictures`, and names, those that are blurred: edges more than twice as wide as the
// median picture's, and wider than 4 px.
std::vector<RejectedPicture> TakeOutBlurred(std::vector<BoardPicture>& pictures);

}  // namespace pleinair

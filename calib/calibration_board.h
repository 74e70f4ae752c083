// Flat boards for the calibration of lenses, chessboard or ChArUco, and their corners in pictures.
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

  bool operator==(const CharucoMarkers&) const = default;
};

// A board's layout.
struct CalibrationBoard {
  BoardSize size;
  std::optional<CharucoMarkers> markers;  // None: a plain chessboard.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
  bool operator==(const CalibrationBoard&) const = default;
};

// One inner corner, in the picture and on the board.
struct BoardCorner {
  glm::dvec2 place_squares{0.0};  // On the board, in sides of a square.
  glm::dvec2 pixel{0.0};

  bool operator==(const BoardCorner&) const = default;
};

// Returns the inner corners, to a fraction of a pixel. For a chessboard these are all corners, row
// by row; for a ChArUco board the visible ones, 6 or more and not on one line. Otherwise what is
// not found, in a few words. Safe from any thread. Throws as CalibrationBoard::Validate.
tl::expected<std::vector<BoardCorner>, std::string> FindBoardCorners(const Gray8Image& picture,
                                                                     const CalibrationBoard& board);

// Returns the number of inner corners of the largest chessboard in the picture, columns >= rows;
// none where no board is found. Parts of a strongly distorted board may be missed: it is the size
// to try, not a measurement.
std::optional<BoardSize> FindBoardSize(const Gray8Image& picture);

// Returns the blur of the picture at the board. It is the width in pixels from 10 % to 90 % of the
// median edge between its squares. 0 where no edge can be measured.
double BoardEdgeWidthPx(const Gray8Image& picture,
                        const CalibrationBoard& board,
                        const std::vector<BoardCorner>& corners);

// The corners of one picture.
struct BoardPicture {
  std::string name;
  std::vector<BoardCorner> corners;
  double edge_width_px = 0.0;   // BoardEdgeWidthPx; 0: not known.
  bool is_always_used = false;  // A person vouches for it: neither blur nor a bad fit counts.
};

// A picture that was left out, and why.
struct RejectedPicture {
  std::string name;
  std::string reason;
};

// Removes the blurred ones from `pictures` and returns them with the reason: edges more than twice
// as wide as the median picture's, and wider than 4 px. Those that are always used stay.
std::vector<RejectedPicture> TakeOutBlurred(std::vector<BoardPicture>& pictures);

// Removes the pictures that show the board where an earlier one does (a copy, a burst) and returns
// them with the reason. They add nothing to the lens, but would make its deviation too small. All
// corners that both see are within a pixel or, where that is more, 1 % of the board's diagonal in
// the picture: a board that is held moves by that. Those that are always used stay.
std::vector<RejectedPicture> TakeOutRepeated(std::vector<BoardPicture>& pictures);

}  // namespace pleinair

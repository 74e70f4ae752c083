// Relative places of markers of one size, from pictures that show several at a time.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/lens.h"
#include "calib/marker_board.h"

namespace pleinair {

// The markers in one picture.
struct MarkerView {
  std::string name;  // The picture's name.
  std::vector<DetectedMarker> markers;
};

// A view that was used, and its fit.
struct FittedMarkerView {
  std::string name;
  std::size_t markers = 0;
  double rms_px = 0.0;
};

// A view that was left out, and why.
struct RejectedMarkerView {
  std::string name;
  std::string reason;
};

// How well one marker is placed.
struct PlacedMarker {
  int id = 0;
  int views = 0;  // Views that show it; with a single view the place is not confirmed.
  double rms_px = 0.0;
};

// The board, and how well views fit.
struct MarkerBoardFit {
  MarkerBoard board;  // In the frame of the reference marker, as MarkerSquare lies in it.
  int reference_id = 0;
  double rms_px = 0.0;  // Over all corners of the fitted views.
  std::vector<PlacedMarker> placed;
  std::vector<FittedMarkerView> fitted;
  std::vector<RejectedMarkerView> rejected;
  std::vector<int> unplaced;  // Ids seen, but never with a placed one.
};

// Places the markers in turn, beginning with `reference_id` (none: the one that most views show).
// Each marker gets the one of its possible poses with the least error over all views. Then follow
// least squares over markers and cameras (Huber's weights beyond 1 px). A view is left out, and
// named, where it shows an id twice or no two placed markers. So is one that fits far worse than
// the others (kWorstViewShare times the median, and more than kWorstViewPx).
//
// Throws  std::invalid_argument: a size that is not positive, an unknown dictionary;
//         std::runtime_error where no two markers can be placed, with what was wrong with the first
//         view that was left out. Also where the rms over the views exceeds kHopelessViewPx:
//         another lens, or markers that moved between the pictures.
MarkerBoardFit FitMarkerBoard(const Lens& lens,
                              const std::string& dictionary,
                              double size_m,
                              std::span<const MarkerView> views,
                              std::optional<int> reference_id = std::nullopt);
inline constexpr double kWorstViewShare = 3.0;
inline constexpr double kWorstViewPx = 1.5;
inline constexpr double kHopelessViewPx = 3.0;

// Turns and moves `board` so that the markers that are also in `anchor` get their places there;
// sizes are not changed. Returns the rms distance of their corners from those places, in metres.
// Throws  std::runtime_error where they share no marker, or use different dictionaries.
double MoveBoardTo(const MarkerBoard& anchor, MarkerBoard& board);

}  // namespace pleinair

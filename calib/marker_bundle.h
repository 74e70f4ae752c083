// Where markers of one size stand to one another, from pictures that show several at a time.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/lens.h"
#include "calib/marker_board.h"

namespace pleinair {

struct MarkerView {
  std::string name;  // Of the picture.
  std::vector<DetectedMarker> markers;
};

struct FittedMarkerView {
  std::string name;
  std::size_t markers = 0;
  double rms_px = 0.0;
};

struct RejectedMarkerView {
  std::string name;
  std::string reason;
};

struct PlacedMarker {
  int id = 0;
  int views = 0;  // That show it; of one seen once nothing else confirms the place.
  double rms_px = 0.0;
};

struct MarkerBoardFit {
  MarkerBoard board;  // In the frame of the reference marker, as MarkerSquare lies in it.
  int reference_id = 0;
  double rms_px = 0.0;  // Over all corners of the fitted views.
  std::vector<PlacedMarker> placed;
  std::vector<FittedMarkerView> fitted;
  std::vector<RejectedMarkerView> rejected;
  std::vector<int> unplaced;  // Ids seen, but never with a placed one.
};

// Places one marker after the other, beginning with `reference_id` (none: the one most views show),
// each by that one of its possible poses that all views together like best; then least squares over
// markers and cameras (Huber's weights beyond 1 px). A view that shows an id twice, shows no two
// placed ones, or fits far worse than the others (kWorstViewShare times the median, and more than
// kWorstViewPx) is left out, and named.
//
// Throws  std::invalid_argument: a size that is not positive, an unknown dictionary;
//         std::runtime_error where no two markers can be placed (with what was wrong with the first
//         view left out), or where they miss the views by more than kHopelessViewPx (rms): not this
//         lens, or markers that moved between the pictures.
MarkerBoardFit FitMarkerBoard(const Lens& lens,
                              const std::string& dictionary,
                              double size_m,
                              std::span<const MarkerView> views,
                              std::optional<int> reference_id = std::nullopt);
inline constexpr double kWorstViewShare = 3.0;
inline constexpr double kWorstViewPx = 1.5;
inline constexpr double kHopelessViewPx = 3.0;

// `board` turned and moved so that the markers that `anchor` has too come to stand where that says;
// returns the rms distance that their corners then miss it by, in metres (sizes are not changed).
// Throws  std::runtime_error where they share no marker, or use different dictionaries.
double MoveBoardTo(const MarkerBoard& anchor, MarkerBoard& board);

}  // namespace pleinair

#include "calib/calibration_board.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/internal/marker_dictionary.h"
#include "calib/internal/opencv_types.h"
#include "calib/internal/residual_text.h"
#include "calib/marker_detection.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

constexpr int kFewestCornersASide = 3;
constexpr std::size_t kFewestCorners = 6;
constexpr double kBlurredShare = 2.0;
constexpr double kBlurredPx = 4.0;

void Refine(const cv::Mat& image, double half_window_px, std::vector<cv::Point2f>& corners) {
  const int half_window = std::clamp(static_cast<int>(half_window_px), 3, 11);
  cv::cornerSubPix(image,
                   corners,
                   {half_window, half_window},
                   {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 50, 0.005});
}

tl::expected<std::vector<BoardCorner>, std::string> FindChessboard(const Gray8Image& picture,
                                                                   BoardSize board) {
  const cv::Mat image = MatOf(picture);
  const cv::Size size(board.columns, board.rows);
  std::vector<cv::Point2f> found;
  // The finder that grows quads also finds boards that the lens distorts. The newer finder, which
  // needs straighter lines, is used only where it fails.
  if (!cv::findChessboardCorners(
          image, size, found, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCornersSB(image, size, found, cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return tl::unexpected("no board of " + TextOf(board) + " inner corners found");
  }
  // Windows of nearly half a square: larger ones look at the next corner.
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < board.Count(); ++i) {
    if ((i + 1) % board.columns == 0) continue;
    const std::size_t index = static_cast<std::size_t>(i);
    nearest = std::min(nearest, cv::norm(found[index + 1] - found[index]));
  }
  Refine(image, 0.45 * nearest, found);
  std::vector<BoardCorner> corners;
  for (int i = 0; i < board.Count(); ++i) {
    const cv::Point2f& at = found[static_cast<std::size_t>(i)];
    corners.push_back({{i % board.columns, i / board.columns}, {at.x, at.y}});
  }
  return corners;
}

bool AreOnALine(const std::vector<BoardCorner>& corners) {
  const glm::dvec2 first = corners[0].place_squares;
  const glm::dvec2 along = corners[1].place_squares - first;
  return std::all_of(corners.begin(), corners.end(), [&](const BoardCorner& corner) {
    const glm::dvec2 to = corner.place_squares - first;
    return along.x * to.y == along.y * to.x;  // Small integers.
  });
}

tl::expected<std::vector<BoardCorner>, std::string> FindCharuco(const Gray8Image& picture,
                                                                BoardSize size,
                                                                const CharucoMarkers& markers) {
  const auto board = cv::aruco::CharucoBoard::create(size.columns + 1,
                                                     size.rows + 1,
                                                     1.0f,
                                                     static_cast<float>(markers.side_share),
                                                     OpenCvDictionary(markers.dictionary));
  std::vector<std::vector<cv::Point2f>> outlines;
  std::vector<int> marker_ids;
  for (const DetectedMarker& marker : DetectMarkers(picture, markers.dictionary)) {
    std::vector<cv::Point2f>& outline = outlines.emplace_back();
    for (const glm::dvec2& corner : marker.corners_px) {
      outline.emplace_back(static_cast<float>(corner.x), static_cast<float>(corner.y));
    }
    marker_ids.push_back(marker.id);
  }
  std::vector<cv::Point2f> found;
  std::vector<int> ids;
  if (!marker_ids.empty()) {
    cv::aruco::interpolateCornersCharuco(outlines, marker_ids, MatOf(picture), board, found, ids);
  }
  if (!found.empty()) {
    // OpenCV 4.6 leaves them half a pixel off, both ways. Windows end before the markers begin.
    double marker_px = std::numeric_limits<double>::infinity();
    for (const auto& outline : outlines) {
      marker_px = std::min(marker_px, cv::norm(outline[1] - outline[0]));
    }
    const double rim_squares = 0.5 * (1.0 - markers.side_share);
    Refine(MatOf(picture), 0.7 * rim_squares * marker_px / markers.side_share, found);
  }
  std::vector<BoardCorner> corners;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    corners.push_back({{ids[i] % size.columns, ids[i] / size.columns}, {found[i].x, found[i].y}});
  }
  if (corners.size() < kFewestCorners || AreOnALine(corners)) {
    return tl::unexpected("expected 6 corners or more of the " + TextOf(size) +
                          " board, not on one line, found " + std::to_string(corners.size()) +
                          " (" + std::to_string(marker_ids.size()) + " markers of " +
                          markers.dictionary + ")");
  }
  return corners;
}

double ValueAt(const Gray8Image& picture, const glm::dvec2& at) {
  const glm::dvec2 inside =
      glm::clamp(at, glm::dvec2(0.0), glm::dvec2(picture.width - 1.001, picture.height - 1.001));
  const int x = static_cast<int>(inside.x);
  const int y = static_cast<int>(inside.y);
  const double fx = inside.x - x;
  const double fy = inside.y - y;
  const auto row = [&](int line) {
    return (1.0 - fx) * picture.At(x, line) + fx * picture.At(x + 1, line);
  };
  return (1.0 - fy) * row(y) + fy * row(y + 1);
}

// Width of the edge between two neighbouring corners; none where the sides hardly differ.
std::optional<double> EdgeWidthPx(const Gray8Image& picture,
                                  const glm::dvec2& from,
                                  const glm::dvec2& to,
                                  double reach_squares) {
  constexpr int kSteps = 64;
  constexpr double kLeastContrast = 20.0;
  const double side = glm::distance(from, to);
  if (!(side > 4.0)) return std::nullopt;
  const double reach = reach_squares * side;
  const glm::dvec2 across = glm::dvec2(from.y - to.y, to.x - from.x) / side;
  std::array<double, kSteps + 1> profile{};
  for (int i = 0; i <= kSteps; ++i) {
    const double distance = reach * (2.0 * i / kSteps - 1.0);
    profile[static_cast<std::size_t>(i)] = ValueAt(picture, 0.5 * (from + to) + distance * across);
  }
  constexpr int kEnd = kSteps / 8;
  double low = 0.0;
  double high = 0.0;
  for (std::size_t i = 0; i < kEnd; ++i) {
    low += profile[i] / kEnd;
    high += profile[kSteps - i] / kEnd;
  }
  if (!(std::abs(high - low) >= kLeastContrast)) return std::nullopt;
  const auto first_at = [&](double share) {
    for (std::size_t i = 1; i <= kSteps; ++i) {
      const double before = (profile[i - 1] - low) / (high - low);
      const double here = (profile[i] - low) / (high - low);
      if (here >= share && here > before) {
        return static_cast<double>(i) - std::min(1.0, (here - share) / (here - before));
      }
    }
    return static_cast<double>(kSteps);
  };
  return std::max(0.0, first_at(0.9) - first_at(0.1)) * 2.0 * reach / kSteps;
}

// Whether the board stands in the same place: no less than half of the corners of either are seen
// in both.
bool ShowTheSame(const BoardPicture& a, const BoardPicture& b) {
  constexpr double kLeastPx = 1.0;
  constexpr double kShareOfDiagonal = 0.01;
  if (a.corners.empty()) return false;
  glm::dvec2 lower = a.corners.front().pixel;
  glm::dvec2 upper = lower;
  for (const BoardCorner& corner : a.corners) {
    lower = glm::min(lower, corner.pixel);
    upper = glm::max(upper, corner.pixel);
  }
  const double reach_px = std::max(kLeastPx, kShareOfDiagonal * glm::distance(lower, upper));
  std::size_t in_both = 0;
  for (const BoardCorner& corner : a.corners) {
    const auto same = std::find_if(b.corners.begin(), b.corners.end(), [&](const auto& other) {
      return other.place_squares == corner.place_squares;
    });
    if (same == b.corners.end()) continue;
    if (!(glm::distance(same->pixel, corner.pixel) <= reach_px)) return false;
    ++in_both;
  }
  return 2 * in_both >= std::max(a.corners.size(), b.corners.size());
}

}  // namespace

void BoardSize::Validate() const {
  for (const int side : {columns, rows}) {
    if (side >= kFewestCornersASide) continue;
    throw std::invalid_argument("board " + TextOf(*this) +
                                ": expected 3 or more inner corners a side");
  }
}

std::string TextOf(BoardSize board) {
  return std::to_string(board.columns) + "x" + std::to_string(board.rows);
}

void CalibrationBoard::Validate() const {
  size.Validate();
  if (!markers) return;
  if (!(markers->side_share > 0.0 && markers->side_share < 1.0)) {
    throw std::invalid_argument("side_share: expected a share between 0 and 1, found " +
                                std::to_string(markers->side_share));
  }
  const int markers_known = OpenCvDictionary(markers->dictionary)->bytesList.rows;
  const int needed = (size.columns + 1) * (size.rows + 1) / 2;
  if (markers_known < needed) {
    throw std::invalid_argument("dictionary " + markers->dictionary + ": expected " +
                                std::to_string(needed) + " markers or more for a board of " +
                                TextOf(size) + ", found " + std::to_string(markers_known));
  }
}

tl::expected<std::vector<BoardCorner>, std::string> FindBoardCorners(
    const Gray8Image& picture, const CalibrationBoard& board) {
  board.Validate();
  if (picture.Empty()) return tl::unexpected(std::string("an empty picture"));
  return board.markers ? FindCharuco(picture, board.size, *board.markers)
                       : FindChessboard(picture, board.size);
}

std::optional<BoardSize> FindBoardSize(const Gray8Image& picture) {
  if (picture.Empty()) return std::nullopt;
  // The smallest allowed board, grown as far as the pattern continues.
  const cv::Size smallest(kFewestCornersASide, kFewestCornersASide);
  const int flags = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER;
  std::vector<cv::Point2f> corners;
  cv::Mat markers;  // As many rows and columns as the board.
  if (!cv::findChessboardCornersSB(MatOf(picture), smallest, corners, flags, markers)) {
    return std::nullopt;
  }
  return BoardSize{std::max(markers.cols, markers.rows), std::min(markers.cols, markers.rows)};
}

double BoardEdgeWidthPx(const Gray8Image& picture,
                        const CalibrationBoard& board,
                        const std::vector<BoardCorner>& corners) {
  // To either side of an edge: most of a square, or of the rim about a marker.
  const double reach_squares = board.markers ? 0.45 * (1.0 - board.markers->side_share) : 0.4;
  if (picture.width < 2 || picture.height < 2) return 0.0;
  std::map<std::pair<int, int>, glm::dvec2> pixel_at;
  for (const BoardCorner& corner : corners) {
    pixel_at[{static_cast<int>(corner.place_squares.x), static_cast<int>(corner.place_squares.y)}] =
        corner.pixel;
  }
  std::vector<double> widths;
  for (const auto& [place, pixel] : pixel_at) {
    for (const auto& next :
         {std::pair(place.first + 1, place.second), std::pair(place.first, place.second + 1)}) {
      const auto neighbour = pixel_at.find(next);
      if (neighbour == pixel_at.end()) continue;
      if (const auto width = EdgeWidthPx(picture, pixel, neighbour->second, reach_squares)) {
        widths.push_back(*width);
      }
    }
  }
  return widths.empty() ? 0.0 : UpperMedian(widths);
}

std::vector<RejectedPicture> TakeOutBlurred(std::vector<BoardPicture>& pictures) {
  std::vector<double> widths;
  widths.reserve(pictures.size());
  for (const BoardPicture& picture : pictures) widths.push_back(picture.edge_width_px);
  if (widths.empty()) return {};
  const double median = UpperMedian(widths);
  const double limit = std::max(kBlurredPx, kBlurredShare * median);
  std::vector<RejectedPicture> blurred;
  std::vector<BoardPicture> sharp;
  for (BoardPicture& picture : pictures) {
    if (picture.is_always_used || picture.edge_width_px <= limit) {
      sharp.push_back(std::move(picture));
      continue;
    }
    blurred.push_back({picture.name,
                       "blurred: edges " + PixelText(picture.edge_width_px) +
                           " wide, where the median picture's have " + PixelText(median)});
  }
  pictures = std::move(sharp);
  return blurred;
}

std::vector<RejectedPicture> TakeOutRepeated(std::vector<BoardPicture>& pictures) {
  std::vector<RejectedPicture> repeated;
  std::vector<BoardPicture> different;
  for (BoardPicture& picture : pictures) {
    const auto first =
        picture.is_always_used
            ? different.end()
            : std::find_if(different.begin(), different.end(), [&](const BoardPicture& other) {
                return ShowTheSame(picture, other);
              });
    if (first == different.end()) {
      different.push_back(std::move(picture));
    } else {
      repeated.push_back({picture.name, "shows the board where " + first->name + " does"});
    }
  }
  pictures = std::move(different);
  return repeated;
}

}  // namespace pleinair

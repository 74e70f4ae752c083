#include "calib/fisheye_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/internal/residual_text.h"
#include "scene/upper_median.h"

namespace pleinair {
namespace {

constexpr std::size_t kFewestPictures = 3;
constexpr int kFewestCornersASide = 3;
// A picture that fits this many times worse than the median one has another fault than this lens:
// corners on the wrong squares, a bent board, motion.
constexpr double kWorstShare = 2.5;
// What corner finding alone may cost on small, strongly bent boards.
constexpr double kWorstPx = 0.75;
// Beyond, it is not this model or not one camera.
constexpr double kHopelessPx = 5.0;

struct Solution {
  FisheyeIntrinsics lens;
  std::vector<double> rms_px;  // A picture each.
  double covered_angle_rad = 0.0;
};

class Calibration {
 public:
  Calibration(BoardSize board, int width_px, int height_px) : size_(width_px, height_px) {
    for (int row = 0; row < board.rows; ++row) {
      for (int column = 0; column < board.columns; ++column) {
        board_.emplace_back(column, row, 0.0);
      }
    }
  }

  // None where OpenCV gives up; *culprit is then the picture that it named, -1 for none.
  std::optional<Solution> Solve(const std::vector<const BoardPicture*>& pictures,
                                int* culprit) const {
    std::vector<std::vector<cv::Vec3d>> boards(pictures.size(), board_);
    std::vector<std::vector<cv::Vec2d>> corners;
    for (const BoardPicture* picture : pictures) {
      std::vector<cv::Vec2d>& points = corners.emplace_back();
      for (const glm::dvec2& corner : picture->corners_px) points.emplace_back(corner.x, corner.y);
    }
    cv::Mat camera;
    cv::Mat distortion;
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    const int flags = cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW |
                      cv::fisheye::CALIB_CHECK_COND;
    try {
      cv::fisheye::calibrate(
          boards, corners, size_, camera, distortion, rotations, translations, flags);
    } catch (const cv::Exception& error) {
      // "... Ill-conditioned matrix for input array 3"
      const std::size_t at = error.err.rfind("array ");
      *culprit = -1;
      if (at != std::string::npos) std::sscanf(error.err.c_str() + at, "array %d", culprit);
      return std::nullopt;
    }
    Solution solution;
    FisheyeIntrinsics& lens = solution.lens;
    lens.model = FisheyeModel::kOpenCv;
    lens.width_px = size_.width;
    lens.height_px = size_.height;
    lens.fx_px = camera.at<double>(0, 0);
    lens.fy_px = camera.at<double>(1, 1);
    lens.cx_px = camera.at<double>(0, 2);
    lens.cy_px = camera.at<double>(1, 2);
    for (int i = 0; i < 4; ++i) {
      lens.distortion[static_cast<std::size_t>(i)] = distortion.at<double>(i);
    }
    lens.max_angle_rad = FisheyeLens::kLargestAngleRad;
    *culprit = -1;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      cv::Mat rotation;
      cv::Rodrigues(rotations[i], rotation);
      solution.rms_px.push_back(
          Residual(lens, cv::Matx33d(rotation), cv::Vec3d(translations[i]), corners[i], solution));
      if (!std::isfinite(solution.rms_px.back())) return std::nullopt;
    }
    return solution;
  }

 private:
  double Residual(const FisheyeIntrinsics& intrinsics,
                  const cv::Matx33d& rotation,
                  const cv::Vec3d& translation,
                  const std::vector<cv::Vec2d>& corners,
                  Solution& solution) const {
    double sum = 0.0;
    try {
      const FisheyeLens lens(intrinsics);
      for (std::size_t i = 0; i < board_.size(); ++i) {
        const cv::Vec3d point = rotation * board_[i] + translation;
        const auto pixel = lens.ProjectToPixel({point[0], point[1], point[2]});
        if (!pixel) return std::numeric_limits<double>::infinity();
        solution.covered_angle_rad = std::max(solution.covered_angle_rad,
                                              std::atan2(std::hypot(point[0], point[1]), point[2]));
        sum += std::pow(pixel->x - corners[i][0], 2.0) + std::pow(pixel->y - corners[i][1], 2.0);
      }
    } catch (const std::invalid_argument&) {
      return std::numeric_limits<double>::infinity();
    }
    return std::sqrt(sum / static_cast<double>(board_.size()));
  }

  cv::Size size_;
  std::vector<cv::Vec3d> board_;
};

double MeanSquareRoot(const std::vector<double>& rms) {
  double sum = 0.0;
  for (const double value : rms) sum += value * value;
  return std::sqrt(sum / static_cast<double>(rms.size()));
}

// What a picture may be off by among these.
double Limit(const Solution& solution) {
  return std::max(kWorstPx, kWorstShare * UpperMedian(solution.rms_px));
}

// Which picture the others do best without; -1 where the rest cannot be solved without any.
int BestLeftOut(const Calibration& calibration, const std::vector<const BoardPicture*>& kept) {
  int best = -1;
  double best_rms = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    std::vector<const BoardPicture*> rest = kept;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    int culprit = -1;
    const auto solution = calibration.Solve(rest, &culprit);
    if (!solution) continue;
    const double rms = MeanSquareRoot(solution->rms_px);
    if (rms < best_rms) {
      best_rms = rms;
      best = static_cast<int>(i);
    }
  }
  return best;
}

[[noreturn]] void GiveUp(const std::vector<RejectedPicture>& rejected, const std::string& why) {
  std::string text = "fish-eye calibration: " + why;
  for (const RejectedPicture& picture : rejected) {
    text += "; " + picture.name + ": " + picture.reason;
  }
  throw std::runtime_error(text);
}

// How far one sees in the picture: to its farthest corner, or where the lens ends.
double PictureAngleRad(const FisheyeIntrinsics& intrinsics) {
  const FisheyeLens lens(intrinsics);
  double angle = 0.0;
  for (const double x : {-0.5, intrinsics.width_px - 0.5}) {
    for (const double y : {-0.5, intrinsics.height_px - 0.5}) {
      const auto direction = lens.DirectionFromPixel({x, y});
      if (!direction) return lens.MaxAngleRad();
      angle = std::max(angle, std::atan2(std::hypot(direction->x, direction->y), direction->z));
    }
  }
  return angle;
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

std::optional<std::vector<glm::dvec2>> FindBoardCorners(const Gray8Image& picture,
                                                        BoardSize board) {
  board.Validate();
  if (picture.Empty()) return std::nullopt;
  const cv::Mat image(
      picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.pixels.data()));
  const cv::Size size(board.columns, board.rows);
  std::vector<cv::Point2f> found;
  // The finder that grows quads follows boards that the lens bends; the newer, straighter one is
  // asked only where it fails.
  if (!cv::findChessboardCorners(
          image, size, found, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCornersSB(image, size, found, cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return std::nullopt;
  }
  // Windows of nearly half a square: larger ones look at the next corner.
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < board.Count(); ++i) {
    if ((i + 1) % board.columns == 0) continue;
    const std::size_t index = static_cast<std::size_t>(i);
    nearest = std::min(nearest, cv::norm(found[index + 1] - found[index]));
  }
  const int half_window = std::clamp(static_cast<int>(0.45 * nearest), 3, 11);
  cv::cornerSubPix(image,
                   found,
                   {half_window, half_window},
                   {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 50, 0.005});
  std::vector<glm::dvec2> corners;
  corners.reserve(found.size());
  for (const cv::Point2f& corner : found) corners.emplace_back(corner.x, corner.y);
  return corners;
}

std::optional<BoardSize> FindBoardSize(const Gray8Image& picture) {
  if (picture.Empty()) return std::nullopt;
  const cv::Mat image(
      picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.pixels.data()));
  // The smallest board that may be asked for, grown as far as the pattern goes on.
  const cv::Size smallest(kFewestCornersASide, kFewestCornersASide);
  const int flags = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER;
  std::vector<cv::Point2f> corners;
  cv::Mat markers;  // As many rows and columns as the board.
  if (!cv::findChessboardCornersSB(image, smallest, corners, flags, markers)) return std::nullopt;
  return BoardSize{std::max(markers.cols, markers.rows), std::min(markers.cols, markers.rows)};
}

FisheyeFit FitFisheyeLens(std::span<const BoardPicture> pictures,
                          BoardSize board,
                          int width_px,
                          int height_px) {
  board.Validate();
  if (width_px <= 0 || height_px <= 0) {
    throw std::invalid_argument(std::string("picture size ") + std::to_string(width_px) + "x" +
                                std::to_string(height_px) + ": expected positive sides");
  }
  std::vector<const BoardPicture*> kept;
  for (const BoardPicture& picture : pictures) {
    if (picture.corners_px.size() != static_cast<std::size_t>(board.Count())) {
      throw std::invalid_argument(picture.name + ": expected " + std::to_string(board.Count()) +
                                  " corners, found " + std::to_string(picture.corners_px.size()));
    }
    kept.push_back(&picture);
  }
  const Calibration calibration(board, width_px, height_px);
  FisheyeFit fit;
  std::vector<const BoardPicture*> left_out;
  const auto reject = [&](std::size_t index, const std::string& reason) {
    fit.rejected.push_back({kept[index]->name, reason});
    left_out.push_back(kept[index]);
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(index));
  };
  std::optional<Solution> solution;
  while (true) {
    if (kept.size() < kFewestPictures) {
      GiveUp(fit.rejected,
             std::string("expected 3 pictures or more that fit one lens, found ") +
                 std::to_string(kept.size()));
    }
    int culprit = -1;
    solution = calibration.Solve(kept, &culprit);
    if (!solution) {
      const bool named = culprit >= 0 && culprit < static_cast<int>(kept.size());
      const int index = named ? culprit : BestLeftOut(calibration, kept);
      if (index < 0) GiveUp(fit.rejected, "no lens fits the pictures, whichever one is left out");
      reject(static_cast<std::size_t>(index), "its board's pose cannot be determined");
      continue;
    }
    const auto worst = std::max_element(solution->rms_px.begin(), solution->rms_px.end());
    if (*worst <= Limit(*solution)) break;
    reject(static_cast<std::size_t>(worst - solution->rms_px.begin()),
           std::string("off by ") + PixelText(*worst) +
               " (rms) where the median picture is off by " +
               PixelText(UpperMedian(solution->rms_px)));
  }
  // While a bad picture bent the lens, good ones may have looked bad.
  for (std::size_t i = left_out.size(); i-- > 0;) {
    std::vector<const BoardPicture*> more = kept;
    more.push_back(left_out[i]);
    int culprit = -1;
    const auto with = calibration.Solve(more, &culprit);
    if (!with || !(*std::max_element(with->rms_px.begin(), with->rms_px.end()) <= Limit(*with))) {
      continue;
    }
    kept = std::move(more);
    solution = with;
    fit.rejected.erase(fit.rejected.begin() + static_cast<std::ptrdiff_t>(i));
  }
  fit.rms_px = MeanSquareRoot(solution->rms_px);
  if (!(fit.rms_px <= kHopelessPx)) {
    GiveUp(
        fit.rejected,
        std::string("expected pictures of one board by one fish-eye lens, but they miss it by ") +
            PixelText(fit.rms_px));
  }
  fit.lens = solution->lens;
  fit.covered_angle_rad = solution->covered_angle_rad;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    fit.fitted.push_back({kept[i]->name, solution->rms_px[i]});
  }
  fit.lens.max_angle_rad = PictureAngleRad(fit.lens);
  return fit;
}

std::string DoubtAbout(const FisheyeFit& fit) {
  const double aspect = std::abs(fit.lens.fx_px / fit.lens.fy_px - 1.0);
  if (fit.rms_px <= kLargestCredibleRmsPx && aspect <= kLargestPixelAspect) return {};
  return "corners are missed by " + PixelText(fit.rms_px) + " (rms), fx is " +
         PixelText(fit.lens.fx_px) + " and fy " + PixelText(fit.lens.fy_px) +
         ": expected at most 1 px, and fx within 3 % of fy";
}

}  // namespace pleinair

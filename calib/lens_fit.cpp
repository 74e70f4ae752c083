#include "calib/lens_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include <opencv2/calib3d.hpp>

#include "calib/internal/board_matches.h"
#include "calib/internal/opencv_types.h"
#include "calib/internal/pose_refinement.h"
#include "calib/internal/reprojection.h"
#include "calib/internal/residual_text.h"
#include "calib/lens.h"
#include "scene/upper_median.h"
#include "sunmodel/angles.h"

namespace pleinair {
namespace {

constexpr std::size_t kFewestPictures = 3;
constexpr std::size_t kFewestCorners = 6;
// A picture that fits this many times worse than the median one has another fault than this lens:
// corners on the wrong squares, a bent board, motion.
constexpr double kWorstShare = 2.5;
// Error of corner finding on small, strongly distorted boards.
constexpr double kWorstPx = 0.75;
// Beyond, it is not this model or not one camera.
constexpr double kHopelessPx = 5.0;

constexpr std::size_t kHeldOutParts = 5;
constexpr double kHeldOutCapPx = 20.0;
constexpr double kPinholeShare = 1.1;

using BoardPictures = std::vector<const BoardPicture*>;

struct Solution {
  AnyLens lens;
  std::vector<glm::dmat4> camera_from_board;  // A picture each.
  std::vector<double> rms_px;
  double covered_angle_rad = 0.0;
};

double MeanSquareRoot(const std::vector<double>& rms) {
  double sum = 0.0;
  for (const double value : rms) sum += value * value;
  return std::sqrt(sum / static_cast<double>(rms.size()));
}

// Infinite where a corner is not before the camera.
double RmsPx(const AnyLens& lens,
             const BoardPicture& picture,
             const glm::dmat4& camera_from_board,
             double& covered_angle_rad) {
  double sum = 0.0;
  for (const PointMatch& match : MatchesOf(picture)) {
    const glm::dvec4 at = camera_from_board * glm::dvec4(match.point_world_m, 1.0);
    const std::array<double, 3> point{at.x, at.y, at.z};
    std::array<double, 2> error{};
    std::visit([&](const auto& model) { PixelError(model, point, match.pixel, error.data()); },
               lens);
    sum += error[0] * error[0] + error[1] * error[1];
    covered_angle_rad = std::max(covered_angle_rad, std::atan2(std::hypot(at.x, at.y), at.z));
  }
  return std::sqrt(sum / static_cast<double>(picture.corners.size()));
}

template <typename Intrinsics>
Intrinsics IntrinsicsFrom(const cv::Size& size, const cv::Mat& camera, const cv::Mat& distortion) {
  Intrinsics lens;
  lens.width_px = size.width;
  lens.height_px = size.height;
  lens.fx_px = camera.at<double>(0, 0);
  lens.fy_px = camera.at<double>(1, 1);
  lens.cx_px = camera.at<double>(0, 2);
  lens.cy_px = camera.at<double>(1, 2);
  for (std::size_t i = 0; i < lens.distortion.size(); ++i) {
    lens.distortion[i] = distortion.at<double>(static_cast<int>(i));
  }
  return lens;
}

// OpenCV's solvers, for pictures of one size.
class LensSolver {
 public:
  LensSolver(LensModel model, cv::Size size) : model_(model), size_(size) {}

  // None where OpenCV gives up; *culprit is then the picture that it named, -1 for none.
  std::optional<Solution> Solve(const BoardPictures& pictures, int* culprit) const {
    *culprit = -1;
    cv::Mat camera;
    cv::Mat distortion;
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    Solution solution;
    try {
      if (model_ == LensModel::kPinhole) {
        std::vector<std::vector<cv::Point3f>> boards;
        std::vector<std::vector<cv::Point2f>> corners;
        Fill(pictures, boards, corners);
        cv::calibrateCamera(boards, corners, size_, camera, distortion, rotations, translations);
        solution.lens = IntrinsicsFrom<CameraIntrinsics>(size_, camera, distortion);
      } else {
        std::vector<std::vector<cv::Point3d>> boards;
        std::vector<std::vector<cv::Point2d>> corners;
        Fill(pictures, boards, corners);
        const int flags = cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW |
                          cv::fisheye::CALIB_CHECK_COND;
        cv::fisheye::calibrate(
            boards, corners, size_, camera, distortion, rotations, translations, flags);
        FisheyeIntrinsics lens = IntrinsicsFrom<FisheyeIntrinsics>(size_, camera, distortion);
        lens.model = FisheyeModel::kOpenCv;
        lens.max_angle_rad = FisheyeLens::kLargestAngleRad;
        solution.lens = lens;
      }
    } catch (const cv::Exception& error) {
      // "... Ill-conditioned matrix for input array 3"
      const std::size_t at = error.err.rfind("array ");
      if (at != std::string::npos) std::sscanf(error.err.c_str() + at, "array %d", culprit);
      return std::nullopt;
    }
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      solution.camera_from_board.push_back(PoseFrom(rotations[i], translations[i]));
      solution.rms_px.push_back(RmsPx(solution.lens,
                                      *pictures[i],
                                      solution.camera_from_board.back(),
                                      solution.covered_angle_rad));
      if (!std::isfinite(solution.rms_px.back())) return std::nullopt;
    }
    return solution;
  }

 private:
  template <typename Point3, typename Point2>
  static void Fill(const BoardPictures& pictures,
                   std::vector<std::vector<Point3>>& boards,
                   std::vector<std::vector<Point2>>& corners) {
    for (const BoardPicture* picture : pictures) {
      boards.emplace_back();
      corners.emplace_back();
      for (const BoardCorner& corner : picture->corners) {
        boards.back().push_back(cv::Point3d(corner.place_squares.x, corner.place_squares.y, 0.0));
        corners.back().push_back(cv::Point2d(corner.pixel.x, corner.pixel.y));
      }
    }
  }

  LensModel model_;
  cv::Size size_;
};

// Largest rms of a picture among these.
double Limit(const Solution& solution) {
  return std::max(kWorstPx, kWorstShare * UpperMedian(solution.rms_px));
}

// The picture that fits worst, of those that may be left out; none: none may.
std::optional<std::size_t> WorstOf(const BoardPictures& pictures, const Solution& solution) {
  std::optional<std::size_t> worst;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i]->is_always_used) continue;
    if (!worst || solution.rms_px[i] > solution.rms_px[*worst]) worst = i;
  }
  return worst;
}

bool FitsBadly(const BoardPictures& pictures, const Solution& solution) {
  const auto worst = WorstOf(pictures, solution);
  return worst && !(solution.rms_px[*worst] <= Limit(solution));
}

// The picture whose removal improves the fit of the others most, of those that may be left out; -1
// where no removal gives a solution.
int BestLeftOut(const LensSolver& solver, const BoardPictures& kept) {
  int best = -1;
  double best_rms = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i]->is_always_used) continue;
    BoardPictures rest = kept;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    int culprit = -1;
    const auto solution = solver.Solve(rest, &culprit);
    if (!solution) continue;
    const double rms = MeanSquareRoot(solution->rms_px);
    if (rms < best_rms) {
      best_rms = rms;
      best = static_cast<int>(i);
    }
  }
  return best;
}

[[noreturn]] void GiveUp(LensModel model,
                         const std::vector<RejectedPicture>& rejected,
                         const std::string& why) {
  std::string text = std::string(LensModelName(model)) + " lens: " + why;
  for (const RejectedPicture& picture : rejected) {
    text += "; " + picture.name + ": " + picture.reason;
  }
  throw std::runtime_error(text);
}

double LargestAngleRad(const CameraIntrinsics& lens) { return std::atan(Lens(lens).ValidRadius()); }
double LargestAngleRad(const FisheyeIntrinsics& lens) { return FisheyeLens(lens).MaxAngleRad(); }

// Largest angle in the picture: at its farthest corner, or where the lens ends.
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

// Error of the prediction of each of `pictures` by lenses fitted to the others. All together have a
// solution; the rest of the `count_all` pictures counts as not predicted.
HeldOutError HoldOut(const LensSolver& solver,
                     const BoardPictures& pictures,
                     std::size_t count_all) {
  int culprit = -1;
  const auto all = solver.Solve(pictures, &culprit);
  HeldOutError held_out;
  std::vector<double> focal_px;
  double sum = kHeldOutCapPx * kHeldOutCapPx * static_cast<double>(count_all - pictures.size()) /
               static_cast<double>(count_all);
  for (std::size_t part = 0; part < kHeldOutParts; ++part) {
    BoardPictures rest;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (i % kHeldOutParts != part) rest.push_back(pictures[i]);
    }
    const auto solution = solver.Solve(rest, &culprit);
    if (solution) {
      focal_px.push_back(std::visit([](const auto& lens) { return lens.fx_px; }, solution->lens));
    }
    for (std::size_t i = part; i < pictures.size(); i += kHeldOutParts) {
      const std::vector<PointMatch> matches = MatchesOf(*pictures[i]);
      double squared = kHeldOutCapPx * kHeldOutCapPx;
      if (all && solution) {
        const auto refined = std::visit(
            [&](const auto& lens) { return RefinePose(lens, matches, all->camera_from_board[i]); },
            solution->lens);
        if (refined) {
          squared =
              std::min(squared, refined->sum_squares_px / static_cast<double>(matches.size()));
        }
      }
      sum += squared / static_cast<double>(count_all);
    }
  }
  held_out.rms_px = std::sqrt(sum);
  double mean = 0.0;
  const double count = static_cast<double>(focal_px.size());
  for (const double focal : focal_px) mean += focal / count;
  for (const double focal : focal_px) {
    held_out.focal_sigma_px += (count - 1.0) / count * (focal - mean) * (focal - mean);
  }
  held_out.focal_sigma_px = std::sqrt(held_out.focal_sigma_px);
  return held_out;
}

}  // namespace

const char* LensModelName(LensModel model) {
  return model == LensModel::kPinhole ? "pinhole" : "fisheye";
}

double LensFit::FxPx() const {
  return std::visit([](const auto& model) { return model.fx_px; }, lens);
}
double LensFit::FyPx() const {
  return std::visit([](const auto& model) { return model.fy_px; }, lens);
}

LensFit FitLens(std::span<const BoardPicture> pictures,
                LensModel model,
                int width_px,
                int height_px) {
  if (width_px <= 0 || height_px <= 0) {
    throw std::invalid_argument(std::string("picture size ") + std::to_string(width_px) + "x" +
                                std::to_string(height_px) + ": expected positive sides");
  }
  BoardPictures kept;
  for (const BoardPicture& picture : pictures) {
    if (picture.corners.size() < kFewestCorners) {
      throw std::invalid_argument(picture.name + ": expected 6 corners or more, found " +
                                  std::to_string(picture.corners.size()));
    }
    kept.push_back(&picture);
  }
  const LensSolver solver(model, {width_px, height_px});
  LensFit fit;
  BoardPictures left_out;
  const auto reject = [&](std::size_t index, const std::string& reason) {
    fit.rejected.push_back({kept[index]->name, reason});
    left_out.push_back(kept[index]);
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(index));
  };
  std::optional<Solution> solution;
  while (true) {
    if (kept.size() < kFewestPictures) {
      GiveUp(model,
             fit.rejected,
             std::string("expected 3 pictures or more that fit one lens, found ") +
                 std::to_string(kept.size()));
    }
    int culprit = -1;
    solution = solver.Solve(kept, &culprit);
    if (!solution) {
      const bool named = culprit >= 0 && culprit < static_cast<int>(kept.size()) &&
                         !kept[static_cast<std::size_t>(culprit)]->is_always_used;
      const int index = named ? culprit : BestLeftOut(solver, kept);
      if (index < 0) {
        GiveUp(model, fit.rejected, "no lens fits the pictures, whichever one is left out");
      }
      reject(static_cast<std::size_t>(index), "its board's pose cannot be determined");
      continue;
    }
    if (!FitsBadly(kept, *solution)) break;
    const std::size_t worst = *WorstOf(kept, *solution);
    reject(worst,
           std::string("off by ") + PixelText(solution->rms_px[worst]) +
               " (rms) where the median picture is off by " +
               PixelText(UpperMedian(solution->rms_px)));
  }
  // While a bad picture bent the lens, good ones may have looked bad.
  for (std::size_t i = left_out.size(); i-- > 0;) {
    BoardPictures more = kept;
    more.push_back(left_out[i]);
    int culprit = -1;
    const auto with = solver.Solve(more, &culprit);
    if (!with || FitsBadly(more, *with)) continue;
    kept = std::move(more);
    solution = with;
    fit.rejected.erase(fit.rejected.begin() + static_cast<std::ptrdiff_t>(i));
  }
  fit.rms_px = MeanSquareRoot(solution->rms_px);
  if (!(fit.rms_px <= kHopelessPx)) {
    GiveUp(model,
           fit.rejected,
           "expected pictures of one board by one such lens, but they miss it by " +
               PixelText(fit.rms_px));
  }
  fit.lens = solution->lens;
  fit.covered_angle_rad = solution->covered_angle_rad;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    fit.fitted.push_back({kept[i]->name, solution->rms_px[i]});
  }
  double largest_angle_rad = 0.0;
  try {
    largest_angle_rad =
        std::visit([](const auto& lens) { return LargestAngleRad(lens); }, fit.lens);
  } catch (const std::invalid_argument& error) {
    GiveUp(model, fit.rejected, error.what());
  }
  if (!(fit.covered_angle_rad <= largest_angle_rad)) {
    std::array<char, 120> why{};
    std::snprintf(why.data(),
                  why.size(),
                  "its distortion folds %.1f deg from the axis, but boards are seen at %.1f deg",
                  DegFromRad(largest_angle_rad),
                  DegFromRad(fit.covered_angle_rad));
    GiveUp(model, fit.rejected, why.data());
  }
  if (auto* fisheye = std::get_if<FisheyeIntrinsics>(&fit.lens)) {
    fisheye->max_angle_rad = PictureAngleRad(*fisheye);
  }
  return fit;
}

LensChoice ChooseLens(std::span<const BoardPicture> pictures, int width_px, int height_px) {
  LensChoice choice;
  const std::array<LensTrial*, 2> trials{&choice.pinhole, &choice.fisheye};
  std::array<std::optional<LensFit>, 2> fits;
  for (std::size_t i = 0; i < 2; ++i) {
    try {
      fits[i] = FitLens(pictures, static_cast<LensModel>(i), width_px, height_px);
    } catch (const std::runtime_error& error) {
      trials[i]->failure = error.what();
    }
  }
  if (!fits[0] && !fits[1]) {
    throw std::runtime_error(trials[0]->failure + "; " + trials[1]->failure);
  }
  std::array<BoardPictures, 2> fitted;
  std::size_t fitted_by_either = 0;
  for (const BoardPicture& picture : pictures) {
    bool by_either = false;
    for (std::size_t i = 0; i < 2; ++i) {
      if (!fits[i] || std::none_of(fits[i]->fitted.begin(),
                                   fits[i]->fitted.end(),
                                   [&](const auto& one) { return one.name == picture.name; })) {
        continue;
      }
      fitted[i].push_back(&picture);
      by_either = true;
    }
    fitted_by_either += by_either ? 1 : 0;
  }
  std::array<double, 2> error_px{};
  for (std::size_t i = 0; i < 2; ++i) {
    error_px[i] = fits[i] ? fits[i]->rms_px : std::numeric_limits<double>::infinity();
    if (!fits[i] || fitted_by_either < kHeldOutParts) continue;
    const LensSolver solver(static_cast<LensModel>(i), {width_px, height_px});
    trials[i]->held_out = HoldOut(solver, fitted[i], fitted_by_either);
    error_px[i] = trials[i]->held_out->rms_px;
  }
  const bool is_pinhole = fits[0] && (!fits[1] || error_px[0] <= kPinholeShare * error_px[1]);
  choice.fit = std::move(*fits[is_pinhole ? 0 : 1]);
  return choice;
}

std::string DoubtAbout(const LensFit& fit) {
  const double aspect = std::abs(fit.FxPx() / fit.FyPx() - 1.0);
  if (fit.rms_px <= kLargestCredibleRmsPx && aspect <= kLargestPixelAspect) return {};
  return "corners are missed by " + PixelText(fit.rms_px) + " (rms), fx is " +
         PixelText(fit.FxPx()) + " and fy " + PixelText(fit.FyPx()) +
         ": expected at most 1 px, and fx within 3 % of fy";
}

}  // namespace pleinair

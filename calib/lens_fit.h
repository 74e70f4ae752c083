// A lens from pictures of a flat board: pinhole or fish-eye.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "calib/calibration_board.h"
#include "calib/fisheye_lens.h"
#include "scene/camera.h"

namespace pleinair {

// OpenCV's models: five coefficients of distortion, or the fish-eye's four.
enum class LensModel { kPinhole, kFisheye };
// "pinhole", "fisheye".
const char* LensModelName(LensModel model);

using AnyLens = std::variant<CameraIntrinsics, FisheyeIntrinsics>;

// The fit of one picture.
struct FittedPicture {
  std::string name;
  double rms_px = 0.0;
};

// A lens and how well it fits.
struct LensFit {
  // A fish-eye's is of model kOpenCv; max_angle_rad to the picture's farthest corner, or where the
  // distortion folds.
  AnyLens lens;
  double rms_px = 0.0;             // Over all corners of the fitted pictures.
  double covered_angle_rad = 0.0;  // The farthest corner of a board from the axis: beyond, the
                                   // lens is extrapolated.
  std::vector<FittedPicture> fitted;
  std::vector<RejectedPicture> rejected;

  LensModel Model() const { return lens.index() == 0 ? LensModel::kPinhole : LensModel::kFisheye; }
  double FxPx() const;
  double FyPx() const;
};

// Least squares over lens and board poses (cv::calibrateCamera, cv::fisheye::calibrate; no skew). A
// picture that spoils the solution, or fits far worse than the others (kWorstShare times the
// median, and more than kWorstPx), is left out and named. The rest is fitted again; pictures that
// then fit are used again. Pictures that are always used are not left out.
//
// Not seen  boards that reach beyond 90 degrees from the axis are left out: OpenCV's fit cannot
//           hold them.
// Throws    std::invalid_argument: a picture of fewer than 6 corners, a size that is not positive;
//           std::runtime_error where fewer than 3 pictures remain, with what was wrong with the
//           others, or where the lens folds inside the boards' area.
LensFit FitLens(std::span<const BoardPicture> pictures,
                LensModel model,
                int width_px,
                int height_px);

// How well a model predicts pictures that it was not fitted to.
struct HeldOutError {
  // Their boards' poses are fitted, the lens is not. A picture counts at most 20 px, also where the
  // model does not fit it.
  double rms_px = 0.0;
  // Standard deviation of fx, by the jackknife over the parts held out.
  double focal_sigma_px = 0.0;
};

// The result for one model.
struct LensTrial {
  std::optional<HeldOutError> held_out;  // None where there are too few pictures to hold any out.
  std::string failure;                   // Why no lens of this model fits; empty where one does.
};

// The chosen model, and both results.
struct LensChoice {
  LensFit fit;
  LensTrial pinhole;
  LensTrial fisheye;
};

// Returns the model that predicts held-out pictures better. A fifth of the pictures that either
// model fits are held out in turn. The pinhole is taken where it is not worse by more than a tenth.
// Both then describe the lens equally well, and a camera of the scene must be a pinhole. With fewer
// than 5 pictures their own rms decides. Throws as FitLens where neither model fits.
LensChoice ChooseLens(std::span<const BoardPicture> pictures, int width_px, int height_px);

// Returns what is wrong with a fit that is not credible: rms above kLargestCredibleRmsPx, or fx and
// fy further apart than kLargestPixelAspect. Empty where nothing is wrong. Corners of another
// board, or of another board size, give such fits.
inline constexpr double kLargestCredibleRmsPx = 1.0;
inline constexpr double kLargestPixelAspect = 0.03;  // |fx / fy - 1|
std::string DoubtAbout(const LensFit& fit);

}  // namespace pleinair

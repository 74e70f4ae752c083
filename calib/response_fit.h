// Finding a camera's response: from one view at several exposures, or from surfaces whose light is
// known. Curves only rise, strictly: a code and its light lead to each other.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "calib/exposure_merge.h"  // ExposedPicture
#include "calib/response.h"

namespace pleinair {

// How well one channel is known. Codes outside [lowest_code, highest_code] are extrapolated.
struct ResponseChannelFit {
  int lowest_code = 0;
  int highest_code = 0;
  // Relative light, root mean square: how far what was measured lies from the curve.
  double rms_relative = 0.0;
  // Codes at which the unconstrained curve fell, before it was made to rise.
  int falls_repaired = 0;
};

struct ResponseFit {
  ResponseTable table{};  // 1 at code 255; strictly rising.
  std::array<ResponseChannelFit, 3> channels;
};

struct BracketFitOptions {
  // How much a departure from a power law costs against the data.
  double smoothness = 10.0;
};

// Fits ln g with g(code) the light: for each two neighbouring exposures, the median code in the
// darker picture of all pixels that have a given code in the brighter one says that the light at
// these two codes differs by the ratio of the exposures. Least squares over all of these, with the
// curvature of ln g over ln code held small: what no pixel shows goes on as a power law.
//
// Source     Debevec and Malik, SIGGRAPH 1997, section 2.1 for the equations; medians of all pixels
// in
//            place of a few pixels' values: robust against what moves, and clipped codes take no
//            part (OpenCV's CalibrateDebevec gives them a small weight, which bends the curve's
//            upper end).
// Flat ends  the lowest and highest codes that occur at all, and one that rounding may mix with
// each,
//            count as clipped.
// Throws     std::invalid_argument: fewer than two pictures or two different exposures, different
//            sizes; std::runtime_error where too few pixels show two exposures unclipped (what
//            channel).
ResponseFit FitResponseFromBrackets(std::span<const ExposedPicture> pictures,
                                    const BracketFitOptions& options = {});

// A surface whose light is known up to one factor for all (of a channel), and the mean code that
// the camera gave it.
struct ResponseSample {
  double light = 0.0;
  double code = 0.0;  // A fraction: a mean over pixels.
};

// The general monotone curve through samples: ln light isotonic over the code, power laws between
// and beyond. The samples of each channel: three or more, at three or more codes.
// Throws  std::invalid_argument naming channel and sample where light or code cannot be.
ResponseFit FitMonotoneResponse(const std::array<std::vector<ResponseSample>, 3>& samples);

// The curve of logarithmic sensors (HDR video cameras), code = a + b ln(c + light) with b > 0, c >=
// 0 and the light in the samples' own units.
struct LogarithmicCurve {
  double a = 0.0;
  double b = 0.0;
  double c = 0.0;
  double rms_codes = 0.0;

  double LightFromCode(double code) const;  // Below the darkest light's code 0.
  double CodeFromLight(double light) const;
};

struct LogarithmicResponseFit {
  ResponseFit response;
  std::array<LogarithmicCurve, 3> curves;
};

// Source  Hoefflinger, High-Dynamic-Range (HDR) Vision, 2007 (the HDRC sensor's three parameters),
// as
//         grosch-2007, section 4 uses it. Least squares in codes.
// Throws  as FitMonotoneResponse; std::runtime_error where the codes do not rise with the light.
LogarithmicResponseFit FitLogarithmicResponse(
    const std::array<std::vector<ResponseSample>, 3>& samples);

// The least-squares non-falling sequence (pool adjacent violators); weights positive.
std::vector<double> IsotonicRegression(std::span<const double> values,
                                       std::span<const double> weights);

// `linear_of_code` with what falls or stands still made to rise by the least that floats hold
// apart, scaled to 1 at code 255. Values that are not finite or negative count as unknown, and take
// the one before.
std::array<float, 256> StrictlyRising(const std::array<double, 256>& linear_of_code);

}  // namespace pleinair

// Finds a camera's response from one view at several exposures, or from surfaces whose light is
// known. Curves are strictly increasing, and so invertible.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "calib/exposure_merge.h"  // ExposedPicture
#include "calib/response.h"

namespace pleinair {

// Accuracy of one channel. Codes outside [lowest_code, highest_code] are extrapolated.
struct ResponseChannelFit {
  int lowest_code = 0;
  int highest_code = 0;
  // Distance of the measurements from the curve, in relative light, root mean square.
  double rms_relative = 0.0;
  // Codes at which the unconstrained curve fell, before it was made to rise.
  int falls_repaired = 0;
};

// The curve, and the accuracy of each channel.
struct ResponseFit {
  ResponseTable table{};  // 1 at code 255; strictly rising.
  std::array<ResponseChannelFit, 3> channels;
};

// Set-up of the fit.
struct BracketFitOptions {
  // Weight of a departure from a power law against the data.
  double smoothness = 10.0;
};

// Fits ln g, with g(code) the light. For each two neighbouring exposures and each code in the
// brighter picture, the median code of the same pixels in the darker one is found. The light at
// these two codes differs by the ratio of the exposures. Least squares over all of these keep the
// curvature of ln g over ln code small: codes that no pixel has are extrapolated by a power law.
//
// Source     Debevec and Malik, SIGGRAPH 1997, section 2.1 for the equations; medians of all pixels
//            replace a few pixels' values. They are robust against motion, and clipped codes are
//            not used (OpenCV's CalibrateDebevec gives them a small weight, which bends the curve's
//            upper end).
// Flat ends the lowest and highest codes that occur, and one that rounding may mix with each, count
// as clipped.
// Throws     std::invalid_argument: fewer than two pictures or two different exposures, different
//            sizes. std::runtime_error, naming the channel, where too few pixels have two unclipped
//            exposures.
ResponseFit FitResponseFromBrackets(std::span<const ExposedPicture> pictures,
                                    const BracketFitOptions& options = {});

// A surface whose light is known up to one factor for all surfaces (of a channel), and its mean
// code.
struct ResponseSample {
  double light = 0.0;
  double code = 0.0;  // A fraction: a mean over pixels.
};

// Fits the general monotone curve to samples: ln light isotonic over the code, power laws between
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

// The curve and its parameters, per channel.
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

// Returns `linear_of_code` made strictly increasing, by the smallest steps that floats distinguish,
// and scaled to 1 at code 255. Values that are not finite or negative count as unknown, and are
// replaced by the one before.
std::array<float, 256> StrictlyRising(const std::array<double, 256>& linear_of_code);

}  // namespace pleinair

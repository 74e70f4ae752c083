// A response from a bracket of which some pictures may be unusable.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calib/response_fit.h"

namespace pleinair {

// A picture's light compared with that of the others, by the curve.
struct BracketPicture {
  // False where the numbers below are not measured: of three pictures or fewer, or where hardly any
  // other shows its pixels unclipped.
  bool is_compared = false;
  // Median over pixels, natural logarithm: not 0 where its exposure is not as stated.
  double offset = 0.0;
  // Median of the absolute deviations: large where the picture shows something else.
  double scatter = 0.0;
  std::string reason;  // Why it is left out; empty where it counts.
};

// The response, and the judgement of each picture.
struct BracketFit {
  ResponseFit response;
  std::vector<BracketPicture> pictures;  // As they were given.
};

// FitResponseFromBrackets without the pictures that contradict the others. A picture contradicts
// them where its light differs from the median picture's by more than kLargestOffset, or scatters
// by more than kLargestScatter. The worst is left out and the rest fitted again, down to three
// pictures.
// Throws  as FitResponseFromBrackets.
inline constexpr double kLargestOffset = 0.2;  // A sixth of a stop is 0.12.
inline constexpr double kLargestScatter = 0.4;
BracketFit FitBracket(std::span<const ExposedPicture> pictures,
                      const BracketFitOptions& options = {});

// Returns why a curve from a bracket is no camera's: the pictures contradict it by more than
// kLargestCredibleBracketRms, or it is nearly flat, its exponent below kLeastExponent over the
// darker or the brighter half of the codes seen. Pictures of several views give such curves, and so
// do wrong exposures. Empty where nothing is wrong.
//
// Of a real bracket of an office the rms is 0.3 to 1.6 %, and 5.5 % with nominal exposures. With
// pictures shifted by 15 px it is 13 to 24 %, with unrelated ones 60 % or more. The exponent is
// 1 of a linear camera, 2.2 of a gamma, and 0.53 where 40 codes are cut off at black.
inline constexpr double kLargestCredibleBracketRms = 0.1;
inline constexpr double kLeastExponent = 0.4;  // Of the light over the code.
std::string DoubtAbout(const ResponseFit& fit);

}  // namespace pleinair

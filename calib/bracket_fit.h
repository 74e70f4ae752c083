// A response from a bracket of which some pictures may be unusable.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calib/response_fit.h"

namespace pleinair {

// A picture's light compared with that of the others, by the curve.
struct BracketPicture {
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

}  // namespace pleinair

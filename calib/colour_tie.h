// Conversion of one camera's colours to those of another.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "calib/response.h"
#include "scene/image.h"

namespace pleinair {

// The same surface or light, linear, seen by both cameras. All channels positive.
struct ColourPair {
  glm::dvec3 from_rgb;
  glm::dvec3 to_rgb;
};

// kScale, one factor for each channel, needs one pair. A full matrix, for sensors whose colours
// differ, needs three pairs that are not all of one hue.
enum class ColourTieKind { kScale, kMatrix };

// The conversion, and how well pairs agree with it.
struct ColourTie {
  glm::dmat3 to_from_rgb{1.0};            // to = matrix * from; diagonal for kScale.
  double rms_relative = 0.0;              // Rms of |matrix * from - to| / |to|, over the inliers.
  std::vector<double> residual_relative;  // One for each pair.
  std::vector<bool> counts;               // False: farther off than kOutlierRatio times the median.
};

// Least squares of relative errors, each pair with the same weight at any brightness. It is
// reweighted until pairs that do not fit (moved, clipped, glossy ones) have no influence.
//
// Throws  std::invalid_argument naming the pair whose colours are not positive, no pair at all;
//         std::runtime_error where the colours do not determine a matrix.
ColourTie FitColourTie(std::span<const ColourPair> pairs, ColourTieKind kind);
inline constexpr double kOutlierRatio = 5.0;

// Returns why pairs are not credible: they are off by more than kLargestCredibleTieRms. Saturated
// colours of two cameras differ by a quarter or so, surfaces of other colours by more. Empty where
// nothing is wrong.
inline constexpr double kLargestCredibleTieRms = 0.4;
std::string DoubtAbout(const ColourTie& tie);

// The mean light of a region that was picked in a picture.
// Throws  std::invalid_argument naming the place: outside the picture, or without a finite pixel.
glm::dvec3 MeanOfDisc(const RgbImage& light, const glm::dvec2& centre_px, double radius_px);

// Returns a camera's response with a factor for each channel included. In the table the largest
// factor is 1, and the others are ratios to it. So light that is read has the other camera's
// colours up to one factor, which belongs to the exposure. Throws std::invalid_argument for a
// factor that is not positive.
ResponseTable TiedResponse(const ResponseCurve& response, const glm::dvec3& factor_rgb);

}  // namespace pleinair

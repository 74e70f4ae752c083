// Two cameras tied in colour: colours that one measures, converted to those of the other.
#pragma once

#include <span>
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

// A factor a channel needs one pair; a full matrix, for sensors whose colours differ, needs three
// that are not all of one hue.
enum class ColourTieKind { kScale, kMatrix };

struct ColourTie {
  glm::dmat3 to_from_rgb{1.0};  // to = matrix * from; diagonal for kScale.
  double rms_relative = 0.0;    // Of |matrix * from - to| / |to|, over the pairs that count.
  std::vector<double> residual_relative;  // A pair each.
  std::vector<bool> counts;               // False: farther off than kOutlierRatio times the median.
};

// Least squares of relative errors, each pair with the same weight however bright, reweighted until
// pairs that do not fit (moved, clipped, glossy ones) no longer pull.
//
// Throws  std::invalid_argument naming the pair whose colours are not positive, no pair at all;
//         std::runtime_error where a matrix is asked of colours that do not determine one.
ColourTie FitColourTie(std::span<const ColourPair> pairs, ColourTieKind kind);
inline constexpr double kOutlierRatio = 5.0;

// The mean light of a region that was picked in a picture.
// Throws  std::invalid_argument naming the place: outside the picture, or without a finite pixel.
glm::dvec3 MeanOfDisc(const RgbImage& light, const glm::dvec2& centre_px, double radius_px);

// A camera's response with a factor for each channel in it: the largest is 1 in the table, and the
// others are their ratios to it, so that what is read has the other camera's colours up to one
// factor, which belongs to the exposure. Throws std::invalid_argument for a factor that is not
// positive.
ResponseTable TiedResponse(const ResponseCurve& response, const glm::dvec3& factor_rgb);

}  // namespace pleinair

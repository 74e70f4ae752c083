// Two cameras tied in colour: colours that one measures, converted to those of the other.
#pragma once

#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

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

}  // namespace pleinair

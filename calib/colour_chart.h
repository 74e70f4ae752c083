// A ColorChecker Classic (24 patches) in a picture: its place, and the colours of its patches.
#pragma once

#include <array>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

inline constexpr int kChartPatches = 24;

// Luminous reflectance of the patches, row by row from dark skin to black.
// Source  McCamy, Marcus and Davidson, Journal of Applied Photographic Engineering 2(3), 1976,
// table
//         of CIE Y (illuminant C).
inline constexpr std::array<double, kChartPatches> kChartReflectance{
    0.101, 0.358, 0.193, 0.133, 0.243, 0.431, 0.301, 0.120, 0.198, 0.066, 0.443, 0.431,
    0.061, 0.234, 0.120, 0.591, 0.198, 0.198, 0.900, 0.591, 0.362, 0.198, 0.090, 0.031};
// The six greys, white first: of nearly one reflectance at all wavelengths, so for every camera.
inline constexpr std::array<int, 6> kChartGreys{18, 19, 20, 21, 22, 23};

// Corners of the field of patches (without the frame): those of dark skin, bluish green, black and
// white, in this order; in a turned picture they are turned too.
using ChartCorners = std::array<glm::dvec2, 4>;

// The colour of one patch.
struct ChartPatch {
  glm::dvec3 mean{0.0};    // Over the inner half of its sides.
  glm::dvec3 stddev{0.0};  // Standard deviation of single pixels there.
};

// Finds the chart with OpenCV's mcc. None where mcc finds none, or where the patches do not match
// the chart in any orientation.
std::optional<ChartCorners> FindColourChart(const Rgb8Image& picture);

// Throws std::invalid_argument where the corners are not those of a convex field inside the
// picture.
std::array<ChartPatch, kChartPatches> MeasureChart(const Rgb8Image& picture,
                                                   const ChartCorners& corners);
std::array<ChartPatch, kChartPatches> MeasureChart(const RgbImage& radiance,
                                                   const ChartCorners& corners);

}  // namespace pleinair

// The greys of a ColorChecker as points of a camera's response.
#pragma once

#include <array>
#include <vector>

#include "calib/colour_chart.h"
#include "calib/response_fit.h"

namespace pleinair {

// Samples of red, green and blue.
using GreySamples = std::array<std::vector<ResponseSample>, 3>;

// Adds the greys of a chart in a picture that has this exposure; greys that are clipped or lost in
// noise are left out.
void AddGreys(const std::array<ChartPatch, kChartPatches>& patches,
              double exposure,
              GreySamples& samples);

}  // namespace pleinair

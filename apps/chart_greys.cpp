#include "apps/chart_greys.h"

#include <cstddef>

#include "calib/response.h"

namespace pleinair {

void AddGreys(const std::array<ChartPatch, kChartPatches>& patches,
              double exposure,
              GreySamples& samples) {
  for (const int grey : kChartGreys) {
    const auto index = static_cast<std::size_t>(grey);
    for (int c = 0; c < 3; ++c) {
      const double code = patches[index].mean[c];
      if (code >= kClippedFromCode - 1 || code <= kNoiseFloorUpToCode) continue;
      samples[static_cast<std::size_t>(c)].push_back({exposure * kChartReflectance[index], code});
    }
  }
}

}  // namespace pleinair

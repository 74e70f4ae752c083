#include "estimation/picture_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "scene/upper_median.h"

namespace pleinair {
namespace {

constexpr std::size_t kLeastCompared = 30;
constexpr std::size_t kLeastOfEither = 10;  // Of those in the sun, and of the others.

// Logarithm of the picture over the light; not finite where either has none.
double LogRatio(const DiffuseSample& sample, const Lighting& lighting, int channel) {
  double light = sample.sun_transport_rgb[channel] * lighting.sun.irradiance_rgb[channel];
  for (std::size_t k = 0; k < lighting.sky.size(); ++k) {
    light += sample.sky_transport_rgb[k][channel] * lighting.sky[k].irradiance_rgb[channel];
  }
  return std::log(sample.radiance_rgb[channel] / light);
}

}  // namespace

std::optional<PictureOverLight> CompareWithPicture(std::span<const DiffuseSample> samples,
                                                   const Lighting& lighting) {
  PictureOverLight result;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> ratios;
    std::array<std::vector<double>, 2> by_lit;
    for (const DiffuseSample& sample : samples) {
      const double ratio = LogRatio(sample, lighting, c);
      const bool is_clipped = std::isinf(sample.radiance_stddev_rgb[c]);
      if (!std::isfinite(ratio) || is_clipped || !(sample.weight > 0.0)) continue;
      ratios.push_back(ratio);
      by_lit[sample.is_lit ? 1 : 0].push_back(ratio);
    }
    if (ratios.size() < kLeastCompared) return std::nullopt;
    const double median = UpperMedianInPlace(ratios);
    result.ratio_rgb[c] = std::exp(median);
    const bool has_shaded = by_lit[0].size() >= kLeastOfEither;
    result.shaded_ratio_rgb[c] = std::exp(has_shaded ? UpperMedianInPlace(by_lit[0]) : median);
    if (c != 1) continue;
    for (double& ratio : ratios) ratio = std::abs(ratio - median);
    result.scatter = std::exp(UpperMedianInPlace(ratios));
    if (std::min(by_lit[0].size(), by_lit[1].size()) < kLeastOfEither) continue;
    result.lit_over_others =
        std::exp(UpperMedianInPlace(by_lit[1]) - UpperMedianInPlace(by_lit[0]));
  }
  return result;
}

}  // namespace pleinair

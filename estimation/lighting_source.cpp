#include "estimation/lighting_source.h"

#include <algorithm>
#include <cmath>

namespace pleinair {

bool LightIsKnown(const Lighting& lighting) {
  constexpr double kLargestPart = 1.0 / 3.0;
  const std::size_t side = 3 * (1 + lighting.sky.size());
  if (lighting.covariance.size() != side * side) return true;  // The source does not doubt it.
  const glm::dvec3 sky = lighting.SkyIrradianceRgb();
  double all = 0.0;
  double deviation = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const int channel = static_cast<int>(c);
    const double sun = lighting.sun.irradiance_rgb[channel];
    const double both = sun + sky[channel];
    all += both;
    // By how much the sun is off with the light of both as it is: with (1 - share) of its own
    // deviation, less the share of the sky's.
    const double share = both > 0.0 ? sun / both : 0.0;
    double variance = 0.0;
    for (std::size_t a = c; a < side; a += 3) {
      for (std::size_t b = c; b < side; b += 3) {
        variance += (a < 3 ? 1.0 - share : -share) * (b < 3 ? 1.0 - share : -share) *
                    lighting.covariance[a * side + b];
      }
    }
    deviation += std::sqrt(std::max(0.0, variance));
  }
  return deviation <= kLargestPart * all;
}

}  // namespace pleinair

#include "estimation/lighting_source.h"

#include <algorithm>
#include <cmath>

namespace pleinair {

bool LightIsKnown(const Lighting& lighting) {
  constexpr double kLargestPart = 1.0 / 3.0;
  const std::size_t side = 3 * (1 + lighting.sky.size());
  if (lighting.covariance.size() != side * side) return true;  // The source does not doubt it.
  const glm::dvec3 all = lighting.sun.irradiance_rgb + lighting.SkyIrradianceRgb();
  double deviation = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    deviation += std::sqrt(std::max(0.0, lighting.covariance[c * (side + 1)]));
  }
  return deviation <= kLargestPart * (all.x + all.y + all.z);
}

}  // namespace pleinair

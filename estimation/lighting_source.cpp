#include "estimation/lighting_source.h"

#include <algorithm>
#include <cmath>

#include "estimation/light_component.h"

namespace pleinair {

bool LightIsKnown(const Lighting& lighting) {
  constexpr double kLargestPart = 1.0 / 3.0;
  if (!HasCovariance(lighting)) return true;  // The source does not doubt it.
  const glm::dvec3& sun = lighting.sun.irradiance_rgb;
  const glm::dvec3 all = sun + lighting.SkyIrradianceRgb();
  const glm::dvec3 common = lighting.common_stddev_rgb * sun;
  double deviation = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double in_common = common[static_cast<int>(c)];
    deviation += std::sqrt(
        std::max(0.0, lighting.covariance[c * (SideOf(lighting) + 1)] - in_common * in_common));
  }
  return deviation <= kLargestPart * (all.x + all.y + all.z);
}

}  // namespace pleinair

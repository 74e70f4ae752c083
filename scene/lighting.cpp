#include "scene/lighting.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pleinair {
namespace {

// `begin` to `end`: rows of the covariance.
MeanIrradiance MeanOver(const Lighting& lighting,
                        const glm::dvec3& rgb,
                        std::size_t begin,
                        std::size_t end) {
  MeanIrradiance result{(rgb.x + rgb.y + rgb.z) / 3.0, 0.0};
  const std::size_t side = 3 * (1 + lighting.sky.size());
  if (lighting.covariance.size() != side * side) return result;
  double variance = 0.0;
  for (std::size_t a = begin; a < end; ++a) {
    for (std::size_t b = begin; b < end; ++b) variance += lighting.covariance[a * side + b];
  }
  result.stddev = std::sqrt(std::max(0.0, variance)) / 3.0;
  return result;
}

}  // namespace

const char* NameOf(LightUnits units) {
  switch (units) {
    case LightUnits::kAbsolute:
      return "absolute";
    case LightUnits::kRelative:
      return "relative";
    case LightUnits::kRelativePerFrame:
      return "relative per frame";
  }
  return "";
}

MeanIrradiance MeanSunIrradiance(const Lighting& lighting) {
  return MeanOver(lighting, lighting.sun.irradiance_rgb, 0, 3);
}

MeanIrradiance MeanSkyIrradiance(const Lighting& lighting) {
  return MeanOver(lighting, lighting.SkyIrradianceRgb(), 3, 3 * (1 + lighting.sky.size()));
}

}  // namespace pleinair

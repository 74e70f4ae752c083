// One number of a light, by its row in the covariance.
#pragma once

#include <cstddef>

#include "scene/lighting.h"

namespace pleinair {

inline std::size_t SideOf(const Lighting& lighting) { return 3 * (1 + lighting.sky.size()); }

inline bool HasCovariance(const Lighting& lighting) {
  return lighting.covariance.size() == SideOf(lighting) * SideOf(lighting);
}

// The value of basis light u / 3, channel u % 3: Lighting::covariance's order.
template <typename MaybeConstLighting>
auto& Component(MaybeConstLighting& lighting, std::size_t u) {
  const auto channel = static_cast<int>(u % 3);
  return u < 3 ? lighting.sun.irradiance_rgb[channel]
               : lighting.sky[u / 3 - 1].irradiance_rgb[channel];
}

// Multiplies the deviations of a component, where there are any, as the component itself is.
inline void ScaleDeviations(std::size_t u, double factor, Lighting& lighting) {
  const std::size_t side = SideOf(lighting);
  for (std::size_t v = 0; v < side && HasCovariance(lighting); ++v) {
    lighting.covariance[u * side + v] *= factor;
    lighting.covariance[v * side + u] *= factor;
  }
}

}  // namespace pleinair

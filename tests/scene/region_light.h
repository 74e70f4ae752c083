// What a region of the sky gives, in closed form.
#pragma once

#include <cstddef>
#include <numbers>

#include "scene/sky_regions.h"

namespace pleinair {

// Irradiance of an unoccluded horizontal plane by unit radiance of `region`. They sum to pi.
inline double HorizontalIrradiance(const SkyRegions& regions, std::size_t region) {
  // The integral of sin(e) over the region's solid angle: pi / S (sin^2 e1 - sin^2 e0).
  const auto sectors = static_cast<double>(regions.Sectors());
  const auto bands = static_cast<double>(regions.Bands());
  const std::size_t band = region / static_cast<std::size_t>(regions.Sectors());
  return std::numbers::pi * (2.0 * static_cast<double>(band) + 1.0) / (sectors * bands * bands);
}

}  // namespace pleinair

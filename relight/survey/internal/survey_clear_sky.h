// The clear sky over a site, between its clouds, as its survey map shows it.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

struct ClearSkyOfMap {
  double aerosol_optical_depth_500nm = 0.0;
  // On a horizontal plane, from the whole sky, had it no clouds; in the map's units. None where the
  // sky is not like the model's: a few clouds are left out, walls or a broken sky are not.
  std::optional<glm::dvec3> irradiance_rgb;
};

// The cloudless sky (ClearSkyDistribution) that, mixed with a uniform and an overcast one, comes
// nearest to what `radiance` shows of the sky. Clouds are outliers: the fit is robust, each channel
// by itself. A sky with little information, as an overcast one, gives the standard depth; one too
// small for any, or without a sun above the horizon, nothing.
//
// `shows_sky`  of the map's size: not zero where the pixel sees past the scene, above the horizon.
std::optional<ClearSkyOfMap> MeasureClearSky(const RgbImage& radiance,
                                             const Gray8Image& shows_sky,
                                             const glm::dvec3& sun_direction_enu);

}  // namespace pleinair

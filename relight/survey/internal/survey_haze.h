// How hazy the air over a site is, from the sky that its survey map shows.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "scene/image.h"

namespace pleinair {

// The aerosol optical depth at 500 nm whose cloudless sky (ClearSkyDistribution), mixed with a
// uniform and an overcast one, comes nearest to what `radiance` shows of the sky. Clouds are
// outliers: the fit is robust, each channel by itself. A sky with little information, as an
// overcast one, gives the standard depth; one too small for any, or without a sun above the
// horizon, none.
//
// `shows_sky`  of the map's size: not zero where the pixel sees past the scene, above the horizon.
std::optional<double> MeasureAerosolDepth(const RgbImage& radiance,
                                          const Gray8Image& shows_sky,
                                          const glm::dvec3& sun_direction_enu);

}  // namespace pleinair

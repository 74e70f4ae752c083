// Direct and diffuse irradiance of a cloudless sky, in three bands of the visible spectrum.
#pragma once

#include <glm/vec3.hpp>

#include "sunmodel/site.h"

namespace pleinair {

struct ClearSkyIrradiance {
  glm::dvec3 beam_rgb{0.0};     // Normal to the beam, W m^-2 per channel; 0 below the horizon.
  glm::dvec3 diffuse_rgb{0.0};  // On a horizontal plane, from the sky without the disc.
};

// For the sun at `apparent_elevation_rad`. Continuous in it, through the horizon too.
ClearSkyIrradiance ComputeClearSky(const Site& site, double apparent_elevation_rad);

}  // namespace pleinair

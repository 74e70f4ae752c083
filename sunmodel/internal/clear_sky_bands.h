// The clear sky's light at given wavelengths.
#pragma once

#include <array>

#include "sunmodel/clear_sky.h"
#include "sunmodel/site.h"

namespace pleinair {

struct Band {
  double wavelength_um;
  double ozone_per_atm_cm;  // Absorption coefficient: the source's, over the channel.
};

// As ComputeClearSky, at these bands in place of a picture's channels.
ClearSkyIrradiance ComputeClearSkyAt(const std::array<Band, 3>& bands,
                                     const Site& site,
                                     double apparent_elevation_rad,
                                     const ClearSkyConditions& conditions);

}  // namespace pleinair

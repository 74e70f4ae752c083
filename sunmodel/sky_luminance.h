// Relative luminance of overcast and cloudless skies over direction.
#pragma once

#include <glm/vec3.hpp>

#include "sunmodel/clear_sky.h"

namespace pleinair {

// The CIE's overcast sky: three times as bright at the zenith as at the horizon. Relative; 0 below
// the horizon. A vertical wall before it gets 0.396 of the horizontal irradiance.
//
// Source     Moon and Spencer, Illuminating Engineering 37, 1942; ISO 15469, type 16.
double OvercastSkyLuminance(const glm::dvec3& direction_enu);

// A cloudless sky in three channels, of light that air and haze have scattered once. It is
// brightest around the sun, more so with more haze, and brighter and paler towards the horizon.
// Light that is scattered again is nearly even over the sky: add a uniform sky for it.
//
// Source     Single scattering in plane layers (Chandrasekhar, Radiative Transfer, 1950, section
//            VI.47.1) by air (Rayleigh) and by haze (Henyey and Greenstein, Astrophysical Journal
//            93, 1941, with g = 0.65); optical depths as in clear_sky.h, paths as RelativeAirMass.
// Accuracy   With the haze that fits them, and a share of uniform and overcast sky, it agrees with
//            six panoramas of clear skies to 4 to 15 %. This is as well as, or better than, the
//            form of Perez, Seals and Michalsky with Preetham's coefficients, which are too bright
//            around the sun for air without haze.
// Continuous in the sun's direction; a sun below the horizon counts as one on it.
class ClearSkyDistribution {
 public:
  // Throws std::invalid_argument for a direction that is not finite or zero, or an optical depth
  // outside [0, 5].
  explicit ClearSkyDistribution(const glm::dvec3& sun_direction_enu,
                                double aerosol_optical_depth_500nm = kStandardAerosolDepth500nm);

  // Relative within and between channels, > 0; 0 on and below the horizon. `direction_enu` is unit.
  glm::dvec3 Radiance(const glm::dvec3& direction_enu) const;

 private:
  glm::dvec3 sun_direction_enu_;
  double sun_air_mass_ = 1.0;
  glm::dvec3 air_depth_{0.0};
  glm::dvec3 haze_depth_{0.0};
};

}  // namespace pleinair

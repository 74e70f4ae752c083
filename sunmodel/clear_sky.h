// Direct and diffuse irradiance of a cloudless sky, in the channels of linear sRGB, each relative
// to the sun's light above the atmosphere.
#pragma once

#include <glm/vec3.hpp>

#include "sunmodel/site.h"

namespace pleinair {

// Haze of the standard spectrum ASTM G173-03: a clear day.
inline constexpr double kStandardAerosolDepth500nm = 0.084;

// Irradiance of a cloudless sky, W m^-2 per channel.
struct ClearSkyIrradiance {
  glm::dvec3 beam_rgb{0.0};     // Normal to the beam, W m^-2 per channel; 0 below the horizon.
  glm::dvec3 diffuse_rgb{0.0};  // On a horizontal plane, from the sky without the disc.
};

// The air, the ground around and the sun's distance. Defaults: the conditions of the standard
// spectrum ASTM G173-03 (rural aerosol), and ground of albedo 0.2.
struct ClearSkyConditions {
  double aerosol_optical_depth_500nm = kStandardAerosolDepth500nm;  // [0, 5].
  double ozone_atm_cm = 0.3438;                                     // [0, 1].
  double ground_albedo = 0.2;    // [0, 1); the sky scatters back what it reflects.
  double sun_distance_au = 1.0;  // [0.9, 1.1].

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Returns the irradiance for the sun at `apparent_elevation_rad`. Continuous in it, also at the
// horizon. The beam fades in while the disc's centre rises by the disc's width, and is exactly 0
// with the centre at or below the horizon. The sky dims by e per degree below it.
//
// Units      Each channel as though the entire solar constant had that channel's loss: above the
//            atmosphere the beam is white, 1361 W m^-2 in every channel at 1 au.
// Source     Bird and Riordan, SERI/TR-215-2436, 1984 (SPECTRL2): section 2 for the beam, section 3
//            for the sky, at one wavelength a channel (internal/optical_depth.h). The pressure is
//            the standard atmosphere's at the site's height; haze and ozone do not thin with it.
//            Twilight is not in it: Glossary of Meteorology, AMS.
// Accuracy   Beam 3 % of ASTM G173 in linear sRGB, in its own conditions. Real clear days differ by
//            their haze: 15 % of the beam, 50 % of the sky are ordinary.
// Throws     std::invalid_argument for a bad site, an elevation outside [-pi/2, pi/2], or bad
//            conditions.
ClearSkyIrradiance ComputeClearSky(const Site& site,
                                   double apparent_elevation_rad,
                                   const ClearSkyConditions& conditions = {});

}  // namespace pleinair

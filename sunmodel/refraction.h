// Atmospheric refraction of the sun's direction, and the air mass of its light.
#pragma once

#include <glm/vec3.hpp>

#include "sunmodel/site.h"

namespace pleinair {

// The standard atmosphere's pressure at sea level (ISO 2533).
inline constexpr double kSeaLevelPressureHpa = 1013.25;

// The air at the site.
struct Atmosphere {
  double pressure_hpa = kSeaLevelPressureHpa;  // [0, 1200].
  double temperature_c = 15.0;                 // [-150, 100].

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// The standard atmosphere at a height; thin but never negative far up.
//
// Source     ISO 2533 to 20 km (lapse of 6.5 K/km to 11 km, constant temperature above), the upper
//            layer carried on beyond: pressure is too low by 15 % at 40 km, where refraction is
//            negligible. Height over the ellipsoid is used as height over the sea: 1 % at most.
// Throws     std::invalid_argument for a height that no Site may have.
Atmosphere StandardAtmosphere(double height_m);

// Apparent minus airless elevation, >= 0 and exactly 0 at the zenith. Apparent elevation is
// continuous and strictly rising in airless elevation; refraction is complete down to -1 deg (the
// disc has set there) and fades smoothly to none at -2 deg.
//
// Source     Saemundsson, Sky and Telescope 72, 1986, p. 70, scaled to pressure and temperature as
//            in Meeus, Astronomical Algorithms, chapter 16, his zenith offset taken off.
// Accuracy   0.1 arc minutes from Bennett's formula (his own bound: 0.07) above the horizon, in the
//            air it assumes; real air near the horizon differs from day to day by several.
// Throws     std::invalid_argument for an elevation outside [-pi/2, pi/2] or a bad atmosphere.
double RefractionRad(double airless_elevation_rad, const Atmosphere& atmosphere);

// The direction lifted towards the zenith, unit; continuous at the zenith too. Throws
// std::invalid_argument for a direction that is zero or not finite.
glm::dvec3 ApparentDirection(const glm::dvec3& airless_direction_enu, const Atmosphere& atmosphere);

// Relative optical air mass (1 at the zenith at sea level) for the apparent elevation; below the
// horizon that at the horizon, 37.9, is kept: finite and positive.
//
// Source     Kasten and Young, Applied Optics 28(22), 1989, equation 3 and table 2.
// Accuracy   0.5 % of their integration, at every elevation above the horizon.
double RelativeAirMass(double apparent_elevation_rad);

}  // namespace pleinair

// How the atmosphere lifts the sun, and how much of it the light crosses.
#pragma once

#include <glm/vec3.hpp>

#include "sunmodel/site.h"

namespace pleinair {

struct Atmosphere {
  double pressure_hpa = 1013.25;
  double temperature_c = 15.0;
};

// The standard atmosphere at a height; thin but never negative far up.
Atmosphere StandardAtmosphere(double height_m);

// Apparent minus airless elevation, >= 0. Apparent elevation is continuous and monotone in airless
// elevation; refraction fades to none below -1 deg.
double RefractionRad(double airless_elevation_rad, const Atmosphere& atmosphere);

// The direction lifted towards the zenith; continuous at the zenith too.
glm::dvec3 ApparentDirection(const glm::dvec3& airless_direction_enu, const Atmosphere& atmosphere);

// Relative optical air mass (1 at the zenith at sea level) for the apparent elevation; finite below
// the horizon too.
double RelativeAirMass(double apparent_elevation_rad);

}  // namespace pleinair

// A survey map's own sun against where it is stated or computed.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "relight/survey/map_sun.h"
#include "scene/image.h"
#include "sunmodel/angles.h"

namespace pleinair {

struct MapSunDisagreement {
  MapSun shown;
  double angle_rad = 0.0;  // Between the two directions.
  double turn_rad = 0.0;   // Between their azimuths.
};

// None where the map shows no sun, or one within `least_rad`, and what is uncertain of it, of
// `expected_enu` (unit): as an angle, and in azimuth, as under a high sun a wrong north moves it
// less than it turns shadows.
std::optional<MapSunDisagreement> CompareWithMapSun(const RgbImage& radiance,
                                                    const glm::dvec3& expected_enu,
                                                    double least_rad = RadFromDeg(3.0));

}  // namespace pleinair

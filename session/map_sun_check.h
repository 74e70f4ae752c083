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

inline constexpr double kWorthAWarningRad = RadFromDeg(3.0);

// None where the map shows no sun, or shows it within `least_rad` of `expected_enu` (unit), its
// uncertainty added. Both the angle and the azimuth are compared: under a high sun a wrong north
// moves the sun less than it turns shadows.
std::optional<MapSunDisagreement> CompareWithMapSun(const RgbImage& radiance,
                                                    const glm::dvec3& expected_enu,
                                                    double least_rad = kWorthAWarningRad);

}  // namespace pleinair

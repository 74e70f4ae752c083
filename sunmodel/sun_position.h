// The sun seen from a site. Geometry only: for refraction see refraction.h.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "scene/utc_time.h"
#include "sunmodel/site.h"

namespace pleinair {

struct SunPosition {
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};  // Unit, from the site to the sun; airless.
  double angular_radius_rad = 0.0;

  double ElevationRad() const;  // Above the horizon plane, in [-pi/2, pi/2].
  double AzimuthRad()
      const;  // Clockwise from true north, [0, 2 pi); without meaning at the zenith.
};

// Earth rotation at the time asked for. Nothing given: TT from the leap second table (before 1972
// from a published Delta T), UT1 - UTC taken as 0 (at most 0.9 s, 0.004 deg).
struct EarthRotation {
  std::optional<double> ut1_minus_utc_s;
  std::optional<double> tt_minus_ut1_s;  // Delta T.
};

// Returns the topocentric, geometric position of the sun's centre.
// Throws std::invalid_argument naming field and value for a bad site or rotation.
SunPosition ComputeSunPosition(const Site& site, UtcTime time, const EarthRotation& rotation = {});

// Whether `time` is in the span that the ephemeris promises its accuracy for (1900 to 2100).
bool IsInEphemerisSpan(UtcTime time);

}  // namespace pleinair

// The sun seen from a site. Geometry only: for refraction see refraction.h.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "scene/utc_time.h"
#include "sunmodel/site.h"

namespace pleinair {

// The sun's centre, as seen from a site.
struct SunPosition {
  glm::dvec3 direction_enu{0.0, 0.0, 1.0};  // Unit, from the site to the sun; airless.
  double angular_radius_rad = 0.0;
  double distance_au = 1.0;

  double ElevationRad() const;  // Above the horizon plane, in [-pi/2, pi/2].
  double AzimuthRad()
      const;  // Clockwise from true north, [0, 2 pi); without meaning at the zenith.
};

// Earth rotation at the requested time. By default TT is from the leap second table: after its end
// the last entry, before 1972 a published Delta T. UT1 - UTC is 0 by default; its size is at most
// 0.9 s, 0.004 deg. A second of Delta T moves the sun by 0.04 arc seconds.
struct EarthRotation {
  std::optional<double> ut1_minus_utc_s;  // [-60, 60].
  std::optional<double> tt_minus_ut1_s;   // Delta T, [-8000, 8000]; overrides the table.

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Returns the topocentric position of the sun's centre without refraction: light time, aberration
// and the site's parallax are in it.
//
// Source     ERFA 2.0: eraEpv00 (ephemeris), eraAb (aberration), eraPnm06a (IAU 2006/2000A
//            precession-nutation), eraGst06 (sidereal time); the site on WGS84 by GeographicLib.
// Accuracy   0.0002 deg, 1900 to 2100, where UT1 is known; polar motion is left out (0.0001 deg).
//            The direction is along the ellipsoid's normal: the local plumb line may differ by
//            0.01 deg in mountains.
// Throws     std::invalid_argument naming field and value for a bad site or rotation.
// Threads    safe from any.
SunPosition ComputeSunPosition(const Site& site, UtcTime time, const EarthRotation& rotation = {});

// Whether `time` is in the span for which the ephemeris states its accuracy (1900 to 2100, both
// years included).
bool IsInEphemerisSpan(UtcTime time);

}  // namespace pleinair

// The norths that a model or a compass may mean, as azimuths from true north.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <glm/vec3.hpp>

#include "scene/utc_time.h"
#include "sunmodel/site.h"

namespace pleinair {

// The north that an azimuth is counted from.
enum class NorthKind {
  kTrue,      // The meridian through the site.
  kGrid,      // The northing lines of the site's UTM zone (near the poles: UPS).
  kMagnetic,  // Where a compass needle points.
};

// Azimuth of grid north: the meridian convergence, clockwise from true north, in (-pi, pi].
//
// Source     Karney, J. Geodesy 85(8), 2011, as GeographicLib's UTMUPS in the site's standard zone.
// Throws     std::invalid_argument for a bad site.
double GridNorthAzimuthRad(const Site& site);

// A field model, and the folder of its file (NAME.wmm beside NAME.wmm.cof).
struct MagneticModelFile {
  std::string name = "wmm2020";
  std::filesystem::path folder;  // Empty: where GeographicLib looks by itself.
};

// Azimuth of magnetic north: the declination, clockwise from true north, in (-pi, pi].
//
// Accuracy   The field models' own: about 0.4 deg away from the magnetic poles; iron nearby and
//            magnetic storms add degrees.
// Throws     std::runtime_error, one line, where the model's file is missing or damaged, or the
//            time or height is outside the model's; std::invalid_argument for a bad site.
double MagneticNorthAzimuthRad(const Site& site, UtcTime time, const MagneticModelFile& model = {});

// `direction_enu` turned clockwise (north to east) about the vertical. What has azimuth A gets
// azimuth A + angle_rad.
glm::dvec3 TurnedClockwise(const glm::dvec3& direction_enu, double angle_rad);

}  // namespace pleinair

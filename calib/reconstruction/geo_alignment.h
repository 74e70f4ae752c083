// Position, north and scale of a reconstruction from what its photographs' receivers and compasses
// say.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair {

// A picture's place in the reconstruction, whose +Z is up, and what its camera says of it.
struct GeoReading {
  glm::dvec3 centre{0.0};
  glm::dvec3 forward{0.0, 1.0, 0.0};         // Where the camera looks.
  std::optional<glm::dvec3> position_enu_m;  // By the receiver; its height does not count.
  double position_sigma_m = 5.0;             // Of each horizontal axis.
  std::optional<double> heading_rad;         // Azimuth of `forward`, clockwise from true north.
  double heading_sigma_rad = 0.2;            // Shared by all: compasses are off together.
};

// enu = scale * turned(model) + translation, where `turned` is counter-clockwise seen from above.
struct GeoAlignment {
  double turn_rad = 0.0;
  double turn_sigma_rad = 0.0;  // Pi: nothing says where north is.
  double scale = 1.0;           // As given, or by the receivers.
  double scale_sigma = 0.0;     // Relative; infinite: nothing says how big it is.
  glm::dvec3 translation{0.0};  // Without a height.
  double position_rms_m = 0.0;  // Of the receivers' positions from the cameras.
  bool has_position = false;
  // By the receivers alone and by the compasses alone, where they say it.
  std::optional<double> turn_by_positions_rad;
  std::optional<double> turn_by_headings_rad;
};

// Robust least squares over the positions (Cauchy), the rotation's mean with the headings weighted
// by their variances. `scale`: metres per unit, where it is known.
GeoAlignment AlignToEarth(std::span<const GeoReading> readings, std::optional<double> scale);

}  // namespace pleinair

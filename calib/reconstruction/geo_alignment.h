// Position, north and scale of a reconstruction from the GPS and compass data of its photographs.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair {

// A picture's place in the reconstruction, whose +Z is up, and its camera's readings.
struct GeoReading {
  glm::dvec3 centre{0.0};
  glm::dvec3 forward{0.0, 1.0, 0.0};         // Direction of view.
  std::optional<glm::dvec3> position_enu_m;  // By GPS; its height is not used.
  double position_sigma_m = 5.0;             // Standard deviation for each horizontal axis.
  std::optional<double> heading_rad;         // Azimuth of `forward`, clockwise from true north.
  double heading_sigma_rad = 0.2;            // Common to all pictures: compass errors are shared.
};

// enu = scale * turned(model) + translation, where `turned` is counter-clockwise seen from above.
struct GeoAlignment {
  double turn_rad = 0.0;
  double turn_sigma_rad = 0.0;  // Pi: north is not known.
  double scale = 1.0;           // As given, or by GPS.
  double scale_sigma = 0.0;     // Relative; infinite: the size is not known.
  glm::dvec3 translation{0.0};  // Without a height.
  double position_rms_m = 0.0;  // Rms of the GPS positions from the cameras.
  bool has_position = false;
  // By GPS only and by compasses only, where these determine it.
  std::optional<double> turn_by_positions_rad;
  std::optional<double> turn_by_headings_rad;
};

// Robust least squares over the positions (Cauchy). The rotation is the mean with the headings,
// with weights of inverse variance. `scale`: metres per unit, where it is known.
GeoAlignment AlignToEarth(std::span<const GeoReading> readings, std::optional<double> scale);

}  // namespace pleinair

#include "session/direction_text.h"

#include <cmath>

#include <fmt/format.h>

#include "sunmodel/angles.h"

namespace pleinair {

std::string AzimuthAndElevation(const glm::dvec3& direction_enu) {
  const double azimuth_deg = DegFromRad(std::atan2(direction_enu.x, direction_enu.y));
  const double elevation_deg =
      DegFromRad(std::atan2(direction_enu.z, std::hypot(direction_enu.x, direction_enu.y)));
  return fmt::format("azimuth {:.1f} deg, elevation {:.1f} deg",
                     azimuth_deg < 0.0 ? azimuth_deg + 360.0 : azimuth_deg,
                     elevation_deg);
}

}  // namespace pleinair

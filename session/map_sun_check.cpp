#include "session/map_sun_check.h"

#include <algorithm>
#include <cmath>

#include "scene/angle_between.h"

namespace pleinair {

std::optional<MapSunDisagreement> CompareWithMapSun(const RgbImage& radiance,
                                                    const glm::dvec3& expected_enu,
                                                    double least_rad) {
  const std::optional<MapSun> shown = FindMapSun(radiance);
  if (!shown) return std::nullopt;
  const glm::dvec3& a = shown->direction_enu;
  const glm::dvec3& b = expected_enu;
  const MapSunDisagreement found{
      .shown = *shown,
      .angle_rad = AngleBetweenRad(a, b),
      .turn_rad = std::abs(std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y))};
  // An azimuth is less certain near the zenith.
  constexpr double kAtTheZenith = 1e-6;
  const double level = std::max(std::min(std::hypot(a.x, a.y), std::hypot(b.x, b.y)), kAtTheZenith);
  const double uncertain_turn_rad = shown->uncertain_rad / level;
  if (found.angle_rad - shown->uncertain_rad >= least_rad) return found;
  if (found.turn_rad - uncertain_turn_rad >= least_rad) return found;
  return std::nullopt;
}

}  // namespace pleinair

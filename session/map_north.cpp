#include "session/map_north.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/sun_state.h"
#include "relight/survey/map_sun.h"
#include "scene/image_io.h"
#include "sunmodel/angles.h"

namespace pleinair {

std::optional<MapNorth> NorthOfMap(const Sequence& sequence) {
  constexpr double kMapToModelRad = RadFromDeg(0.7);
  constexpr double kMostHeightRad = RadFromDeg(2.0);  // A map's level, and its time to minutes.
  constexpr double kLeastLevel = 0.2;                 // Near the zenith the sun says no azimuth.
  if (!sequence.environment || sequence.environment->sun_direction_enu || !sequence.site) {
    return std::nullopt;
  }
  Site true_north = *sequence.site;
  true_north.model_north_azimuth_rad = 0.0;
  const glm::dvec3 computed = SunOverSite(true_north, sequence.environment->time).direction_enu;
  if (!(computed.z > 0.0)) return std::nullopt;
  RgbImage radiance = ReadRadianceImage(sequence.folder / sequence.environment->image);
  RepairRadiance(radiance);
  const std::optional<MapSun> sun = FindMapSun(radiance);
  if (!sun) return std::nullopt;
  const glm::dvec3& shown = sun->direction_enu;
  const auto height_rad = [](const glm::dvec3& direction) {
    return std::asin(std::clamp(direction.z, -1.0, 1.0));
  };
  const double level = std::hypot(shown.x, shown.y);
  if (level < kLeastLevel ||
      std::abs(height_rad(shown) - height_rad(computed)) > kMostHeightRad + sun->uncertain_rad) {
    return std::nullopt;
  }
  const auto azimuth_rad = [](const glm::dvec3& direction) {
    return std::atan2(direction.x, direction.y);
  };
  const double turn_rad = azimuth_rad(computed) - azimuth_rad(shown);
  return MapNorth{std::remainder(turn_rad, 2.0 * std::numbers::pi),
                  std::hypot(kMapToModelRad, sun->uncertain_rad / level)};
}

}  // namespace pleinair

#include "session/map_north.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
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
  const std::filesystem::path file = sequence.folder / sequence.environment->image;
  if (!HoldsRadiance(file)) return std::nullopt;  // What reads it for its light says so.
  RgbImage radiance = ReadRadianceImage(file);
  RepairRadiance(radiance);
  const std::optional<MapSun> sun = FindMapSun(radiance);
  if (!sun || (sun->kind != MapSunKind::kDisc && sun->kind != MapSunKind::kFlatTop)) {
    return std::nullopt;
  }
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
  const MapNorth north{
      std::remainder(azimuth_rad(computed) - azimuth_rad(shown), 2.0 * std::numbers::pi),
      std::hypot(kMapToModelRad, sun->uncertain_rad / level)};
  constexpr double kSurelyTurnedSigmas = 3.0;
  if (std::abs(north.azimuth_rad) < kSurelyTurnedSigmas * north.stddev_rad) return std::nullopt;
  return north;
}

}  // namespace pleinair

#include "scene/sky_regions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace pleinair {

SkyRegions::SkyRegions(int bands, int sectors) : bands_(bands), sectors_(sectors) {
  if (bands < 1 || sectors < 1 || bands > kMostRegions / sectors) {
    throw std::invalid_argument("sky regions: " + std::to_string(bands) + " bands of " +
                                std::to_string(sectors) +
                                " sectors; expected at least 1 of each, and at most " +
                                std::to_string(kMostRegions) + " regions");
  }
}

std::optional<std::size_t> SkyRegions::RegionOf(const glm::dvec3& direction_enu) const {
  if (!(direction_enu.z > 0.0)) return std::nullopt;
  const int band = std::min(static_cast<int>(direction_enu.z * bands_), bands_ - 1);
  double turns = std::atan2(direction_enu.x, direction_enu.y) / (2.0 * std::numbers::pi);
  if (turns < 0.0) turns += 1.0;
  // Less than 5e-17 turns below north is 1.0 in floating point.
  const int sector = std::min(static_cast<int>(turns * sectors_), sectors_ - 1);
  return static_cast<std::size_t>(sectors_) * static_cast<std::size_t>(band) +
         static_cast<std::size_t>(sector);
}

double SkyRegions::SolidAngleSr() const {
  return 2.0 * std::numbers::pi / static_cast<double>(Count());
}

glm::dvec3 SkyRegions::DirectionIn(std::size_t region, const glm::dvec2& point) const {
  const auto sectors = static_cast<std::size_t>(sectors_);
  const std::size_t band = region / sectors;
  const double sine = (static_cast<double>(band) + point.y) / bands_;
  const double azimuth =
      2.0 * std::numbers::pi * (static_cast<double>(region % sectors) + point.x) / sectors_;
  const double cosine = std::sqrt((1.0 - sine) * (1.0 + sine));
  return {cosine * std::sin(azimuth), cosine * std::cos(azimuth), sine};
}

}  // namespace pleinair

#include "scene/sphere_directions.h"

#include <cmath>
#include <numbers>

#include "scene/low_discrepancy.h"

namespace pleinair::internal {
std::vector<glm::vec3> SphereDirections(int count, std::uint64_t seed) {
  const double offset_turns = UnitFromHash(HashBits(seed));
  std::vector<glm::vec3> directions;
  directions.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double height = 1.0 - (2.0 * i + 1.0) / count;
    const double radius = std::sqrt((1.0 - height) * (1.0 + height));
    const double turns = Fraction(i / std::numbers::phi + offset_turns);
    const double azimuth_rad = 2.0 * std::numbers::pi * turns;
    directions.emplace_back(radius * std::cos(azimuth_rad), radius * std::sin(azimuth_rad), height);
  }
  return directions;
}

}  // namespace pleinair::internal

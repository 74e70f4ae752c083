// The upper hemisphere cut into regions of equal solid angle (grosch-2007, section 5.1).
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace pleinair {

// Bands are equal in sin(elevation), band 0 lies on the horizon; sectors are equal in azimuth,
// sector 0 begins at north and they follow clockwise. Region = Sectors() * band + sector.
class SkyRegions {
 public:
  static constexpr int kMostRegions = 4096;

  // Throws std::invalid_argument unless both are at least 1, and their product at most
  // kMostRegions.
  explicit SkyRegions(int bands = 4, int sectors = 16);

  int Bands() const { return bands_; }
  int Sectors() const { return sectors_; }
  std::size_t Count() const {
    return static_cast<std::size_t>(bands_) * static_cast<std::size_t>(sectors_);
  }

  // The region that a unit direction lies in; none on and below the horizon. The zenith lies in
  // the last band's sector 0.
  std::optional<std::size_t> RegionOf(const glm::dvec3& direction_enu) const;
  // Solid angle of each region.
  double SolidAngleSr() const;
  // The direction at a point of the unit square, which is laid over the region so that equal areas
  // are equal solid angles: x along the azimuth, y upwards.
  glm::dvec3 DirectionIn(std::size_t region, const glm::dvec2& point) const;
  // Calls visit(neighbour) for `region` and those that touch it, some twice where sectors are few.
  template <class Visit>
  void ForNeighbours(std::size_t region, const Visit& visit) const {
    const int band = static_cast<int>(region) / sectors_;
    const int sector = static_cast<int>(region) % sectors_;
    for (int b = std::max(0, band - 1); b <= std::min(bands_ - 1, band + 1); ++b) {
      for (int turn = -1; turn <= 1; ++turn) {
        visit(static_cast<std::size_t>(b * sectors_ + (sector + turn + sectors_) % sectors_));
      }
    }
  }

  bool operator==(const SkyRegions&) const = default;

 private:
  int bands_;
  int sectors_;
};

}  // namespace pleinair

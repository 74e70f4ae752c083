// The mean radiance of each region of the sky in fish-eye pictures (grosch-2007, section 5.1).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "calib/fisheye_camera.h"
#include "scene/image.h"
#include "scene/sky_regions.h"

namespace pleinair {

// Set up once for each camera; a picture then costs one read of its pixels.
class RegionAverages {
 public:
  // Keeps no reference to `table`.
  RegionAverages(const FisheyePixelTable& table, const SkyRegions& regions);

  // Whether the camera sees any of the upper hemisphere.
  bool SeesSky() const { return !runs_.empty(); }

  // Averages `radiance` over solid angle, region by region. Pixels that are not finite or below 0
  // are left out; those in `replaced` (each once, above the horizon) count as `replacement`. A
  // region without a pixel has the average of the nearest one above it; in the highest band, the
  // mean of all.
  //
  // Shape    `radiance` has the size of the camera's pictures, unchecked.
  // Accuracy single precision within a row of a region.
  void Average(const RgbImage& radiance,
               std::span<const std::uint32_t> replaced,
               const glm::vec3& replacement);
  // One for each region, from the last picture.
  std::span<const glm::dvec3> Radiance() const { return average_; }

 private:
  // Neighbouring pixels of a row that lie in one region.
  struct Run {
    std::uint32_t begin;
    std::uint32_t end;
    std::uint32_t region;
    float solid_angle_sr;
  };

  SkyRegions regions_;
  std::vector<float> solid_angle_sr_;           // Per pixel.
  std::vector<std::uint32_t> region_of_pixel_;  // Without meaning for pixels outside all runs.
  std::vector<Run> runs_;
  std::vector<glm::dvec3> average_;
  std::vector<double> weight_sr_;  // Solid angle that each average is over.
};

}  // namespace pleinair

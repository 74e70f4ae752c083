// The pixels of a picture that shadows can be read from, and when each of them has sun as the sun
// is turned about the vertical.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

// Candidate offsets of the sun's azimuth: odd in number, evenly spaced, the middle one is 0.
struct OffsetGrid {
  double step_rad = 0.0;
  int half = 0;  // Candidates to either side.

  std::size_t Size() const { return static_cast<std::size_t>(2 * half + 1); }
  double OffsetRad(std::size_t candidate) const {
    return (static_cast<double>(candidate) - half) * step_rad;
  }
  std::size_t Nearest(double offset_rad) const {
    const double steps = std::clamp(offset_rad / step_rad, -double(half), double(half));
    return static_cast<std::size_t>(std::lround(steps) + half);
  }
};

// One pixel's surface, well inside a plane of the mesh.
struct ShadowPixel {
  int x = 0;
  int y = 0;
  std::uint32_t plane = 0;  // Same group, material and facing, whichever picture it is in.
  glm::vec3 start_m{0.0f};  // Start of the shadow ray.
  glm::vec3 normal{0.0f};   // Turned to the camera.
};

// A mesh, and a mark for each triangle that shadows may be read from.
struct UsableSurfaces {
  const Mesh& mesh;
  std::span<const std::uint8_t> usable;
  const RayCaster& caster;
};

// Returns pixels of `camera` on usable triangles, on a regular raster of at most
// `most` pixels. None is nearer to a mesh edge in the picture than mesh and picture may disagree.
// In this and the functions below, what is returned after a stop has no meaning.
std::vector<ShadowPixel> FindShadowPixels(const UsableSurfaces& surfaces,
                                          const Camera& camera,
                                          int most,
                                          const std::stop_token& stop = {});

// Share of the sun at each pixel under each candidate, in quarters, 0 to 4. A shadow's edge is as
// wide as the disc where the grid's step is its radius. Shape: pixels x grid.Size(), row-major.
//
// Not  seen: shadows so narrow that they come and go within four candidates.
std::vector<std::uint8_t> SharesOfSun(std::span<const ShadowPixel> pixels,
                                      const RayCaster& caster,
                                      const glm::dvec3& sun_direction_enu,
                                      const OffsetGrid& grid,
                                      const std::stop_token& stop = {});

// The same of any suns: 4 where a pixel sees the middle of the disc, else 0. Shape: pixels x suns.
std::vector<std::uint8_t> SharesOfSuns(std::span<const ShadowPixel> pixels,
                                       const RayCaster& caster,
                                       std::span<const glm::dvec3> suns,
                                       const std::stop_token& stop = {});

}  // namespace pleinair

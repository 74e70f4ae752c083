// Irradiance at many points that stay where they are while the light changes: an object's vertices.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/volume/irradiance_volume.h"
#include "scene/spherical_harmonics.h"

namespace pleinair {

// Holds, for points of one pose, the probes from which each is interpolated and their weights by
// its normal; a frame is then a sum. See IrradianceAt for the one-off form.
class VertexIrradiance {
 public:
  VertexIrradiance() = default;
  // Throws std::invalid_argument when the spans differ in length, a position or normal is not
  // finite (naming its index), or `volume` has no probes.
  VertexIrradiance(const IrradianceVolume& volume,
                   std::span<const glm::vec3> positions_m,
                   std::span<const glm::vec3> normals);

  // Writes the irradiance of `volume`, which has the grid and the valid probes of the one that this
  // was made with, and any light.
  // Cost    216 multiplications a point; see bench/relight_bench.cpp.
  // Throws  std::invalid_argument when the grid is another or `irradiance` has not one entry a
  //         point.
  void Evaluate(const IrradianceVolume& volume, std::span<glm::vec3> irradiance) const;

 private:
  struct Point {
    std::array<std::uint32_t, 8> probe;
    std::array<float, 8> weight;
    std::array<float, kProbeShCoefficients> basis;
  };
  std::size_t probes_ = 0;
  std::vector<Point> points_;
};

}  // namespace pleinair

#include "relight/volume/vertex_irradiance.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "relight/volume/internal/probe_blend.h"
#include "scene/is_finite.h"

namespace pleinair {
namespace {

// Points a task: some 50 us of work, against some 1 us to hand it to a thread.
constexpr std::size_t kPointsPerTask = 1024;

template <typename Body>
void ForPoints(std::size_t count, const Body& body) {
  if (count <= kPointsPerTask) {
    for (std::size_t i = 0; i < count; ++i) body(i);
    return;
  }
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kPointsPerTask),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
                    });
}

void RequireSound(const IrradianceVolume& volume) {
  const std::size_t probes = volume.grid.ProbeCount();
  if (volume.probes.size() != probes || volume.valid.size() != probes) {
    throw std::invalid_argument("irradiance volume: " + std::to_string(volume.probes.size()) +
                                " probes, " + std::to_string(volume.valid.size()) +
                                " valid flags, expected the grid's " + std::to_string(probes));
  }
}

void RequireFinite(std::span<const glm::vec3> values, const char* name) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (IsFinite(values[i])) continue;
    throw std::invalid_argument("irradiance at points: " + std::string(name) + "[" +
                                std::to_string(i) + "] is not finite");
  }
}

}  // namespace

VertexIrradiance::VertexIrradiance(const IrradianceVolume& volume,
                                   std::span<const glm::vec3> positions_m,
                                   std::span<const glm::vec3> normals)
    : probes_(volume.grid.ProbeCount()), points_(positions_m.size()) {
  RequireSound(volume);
  if (normals.size() != positions_m.size()) {
    throw std::invalid_argument("irradiance at points: " + std::to_string(normals.size()) +
                                " normals, expected one for each of " +
                                std::to_string(positions_m.size()) + " positions");
  }
  RequireFinite(positions_m, "positions_m");
  RequireFinite(normals, "normals");
  ForPoints(points_.size(), [&](std::size_t i) {
    const internal::ProbeBlend blend = internal::BlendAt(volume.grid, volume.valid, positions_m[i]);
    points_[i] = {blend.probe, blend.weight, internal::IrradianceBasisOf(normals[i])};
  });
}

void VertexIrradiance::Evaluate(const IrradianceVolume& volume,
                                std::span<glm::vec3> irradiance) const {
  RequireSound(volume);
  if (volume.grid.ProbeCount() != probes_) {
    throw std::invalid_argument("irradiance at points: a volume of " +
                                std::to_string(volume.grid.ProbeCount()) +
                                " probes, set up for one of " + std::to_string(probes_));
  }
  if (irradiance.size() != points_.size()) {
    throw std::invalid_argument("irradiance at points: room for " +
                                std::to_string(irradiance.size()) + " results, expected " +
                                std::to_string(points_.size()));
  }
  ForPoints(points_.size(), [&](std::size_t i) {
    const Point& point = points_[i];
    irradiance[i] =
        internal::BlendedIrradiance(volume.probes, point.probe, point.weight, point.basis);
  });
}

}  // namespace pleinair

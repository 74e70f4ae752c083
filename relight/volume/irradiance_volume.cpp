#include "relight/volume/irradiance_volume.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "relight/volume/basis_sum.h"
#include "relight/volume/internal/probe_blend.h"
#include "relight/volume/vertex_irradiance.h"

namespace pleinair {
namespace {

using internal::BasisWeights;
using internal::WeightedSum;

constexpr std::string_view kWhat = "irradiance volume";

// Three parts, each one entry a basis light.
std::size_t LightCount(const BasisLights& basis) {
  const std::size_t count = basis.environment.size();
  if (count == 0 || basis.face_radiosity.size() != count || basis.sky_radiance.size() != count) {
    throw std::invalid_argument("basis lights: " + std::to_string(count) + " in environment, " +
                                std::to_string(basis.face_radiosity.size()) +
                                " in face_radiosity, " + std::to_string(basis.sky_radiance.size()) +
                                " in sky_radiance; expected the same number, at least the sun");
  }
  return count;
}

std::vector<ShRgb> Fold(const ProbeOperator& probes, const BasisLights& basis, std::size_t light) {
  return probes.Apply(basis.environment[light].radiance.pixels,
                      basis.face_radiosity[light],
                      basis.sky_radiance[light]);
}

// The weighted sum of what each light makes of faces, or of the sky.
std::vector<glm::vec3> SumOfLights(const std::vector<std::vector<glm::vec3>>& of_light,
                                   std::span<const glm::vec3> weights) {
  std::size_t size = 0;
  for (const std::vector<glm::vec3>& values : of_light) size = std::max(size, values.size());
  const std::vector<std::span<const glm::vec3>> terms(of_light.begin(), of_light.end());
  std::vector<glm::vec3> sum(size);
  WeightedSum(terms, weights, sum, kWhat);
  return sum;
}

bool IsBox(const BoundingBox& box) {
  for (glm::length_t axis = 0; axis < 3; ++axis) {
    if (!(box.lower_m[axis] <= box.upper_m[axis]) || !std::isfinite(box.lower_m[axis]) ||
        !std::isfinite(box.upper_m[axis])) {
      return false;
    }
  }
  return true;
}

}  // namespace

glm::vec3 IrradianceVolume::Irradiance(const glm::vec3& position_m, const glm::vec3& normal) const {
  glm::vec3 irradiance(0.0f);
  IrradianceAt(*this, {&position_m, 1}, {&normal, 1}, {&irradiance, 1});
  return irradiance;
}

void IrradianceAt(const IrradianceVolume& volume,
                  std::span<const glm::vec3> positions_m,
                  std::span<const glm::vec3> normals,
                  std::span<glm::vec3> irradiance) {
  VertexIrradiance(volume, positions_m, normals).Evaluate(volume, irradiance);
}

IrradianceVolume VolumeFromEnvironment(const ProbeOperator& probes,
                                       const BasisLights& basis,
                                       const RgbImage& environment,
                                       const Lighting& lighting) {
  const std::vector<glm::vec3> weights = BasisWeights(lighting, LightCount(basis), kWhat);
  return {probes.Grid(),
          probes.Apply(environment.pixels,
                       SumOfLights(basis.face_radiosity, weights),
                       SumOfLights(basis.sky_radiance, weights)),
          probes.Valid()};
}

std::vector<std::uint8_t> ProbesNeededIn(const ProbeGrid& grid,
                                         std::span<const std::uint8_t> valid,
                                         std::span<const BoundingBox> boxes) {
  grid.Validate();
  if (valid.size() != grid.ProbeCount()) {
    throw std::invalid_argument("probes needed: " + std::to_string(valid.size()) +
                                " valid flags, expected the grid's " +
                                std::to_string(grid.ProbeCount()));
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (IsBox(boxes[i])) continue;
    throw std::invalid_argument("probes needed: boxes[" + std::to_string(i) +
                                "] is not finite with lower <= upper");
  }
  return internal::ProbesReadIn(grid, valid, boxes);
}

FoldedVolume::FoldedVolume(const ProbeOperator& probes, const BasisLights& basis)
    : grid_(probes.Grid()), valid_(probes.Valid()) {
  const std::size_t lights = LightCount(basis);
  probes_of_basis_ = BasisProbes(lights, valid_.size());
  for (std::size_t light = 0; light < lights; ++light) {
    probes_of_basis_.Set(light, Fold(probes, basis, light));
  }
}

void FoldedVolume::Refold(const ProbeOperator& probes,
                          const BasisLights& basis,
                          std::size_t light) {
  if (probes_of_basis_.Lights() == 0) {
    throw std::logic_error("folded volume: Refold before anything was folded");
  }
  if (LightCount(basis) != probes_of_basis_.Lights() || probes.Valid() != valid_ ||
      light >= probes_of_basis_.Lights()) {
    throw std::invalid_argument(
        "folded volume: Refold with another operator, another number of basis lights, or a light "
        "past the last");
  }
  probes_of_basis_.Set(light, Fold(probes, basis, light));
}

void FoldedVolume::Combine(const Lighting& lighting,
                           std::span<const std::uint8_t> needed,
                           IrradianceVolume& volume) const {
  const std::vector<glm::vec3> weights = BasisWeights(lighting, probes_of_basis_.Lights(), kWhat);
  if (!needed.empty() && needed.size() != valid_.size()) {
    throw std::invalid_argument("irradiance volume: marks of " + std::to_string(needed.size()) +
                                " probes, expected " + std::to_string(valid_.size()));
  }
  volume.grid = grid_;
  volume.valid = valid_;
  for (std::size_t probe = 0; probe < needed.size(); ++probe) {
    if (needed[probe] == 0) volume.valid[probe] = 0;
  }
  volume.probes.resize(valid_.size());
  probes_of_basis_.Sum(weights, volume.valid, volume.probes);
}

}  // namespace pleinair

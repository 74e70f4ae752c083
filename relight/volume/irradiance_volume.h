// The irradiance volume for the current light, by either of two routes that give the same probes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/volume/basis_probes.h"
#include "relight/volume/environment.h"
#include "relight/volume/probe_operator.h"
#include "scene/lighting.h"
#include "scene/spherical_harmonics.h"

namespace pleinair {

// Incident radiance on a grid, sun's disc excluded, as SH coefficients.
struct IrradianceVolume {
  ProbeGrid grid;
  std::vector<ShRgb> probes;        // ProbeCount() entries.
  std::vector<std::uint8_t> valid;  // 0: in a wall; not interpolated from.

  // Irradiance at a point on a surface with unit `normal`: trilinear over the valid probes around
  // it, the nearest valid one where none is. Points outside the grid take its border's value. 0
  // where no probe at all is valid.
  //
  // Accuracy  three bands (of a single small source, up to 9.4 % of the irradiance normal to its
  //           beam) and what the grid resolves. Light leaks through a wall that is thinner than the
  //           grid's spacing, never farther than one cell. With all eight probes valid, a point at
  //           distance d before a wall square to a grid axis of spacing h takes at most 1 - d / h
  //           of its light from probes beyond it.
  // Throws    std::invalid_argument for a point or normal that is not finite, or a volume whose
  //           arrays do not fit its grid.
  glm::vec3 Irradiance(const glm::vec3& position_m, const glm::vec3& normal) const;
};

// Irradiance for each of many points; the same as one by one. For points that stay while the light
// changes, VertexIrradiance does the set-up once.
void IrradianceAt(const IrradianceVolume& volume,
                  std::span<const glm::vec3> positions_m,
                  std::span<const glm::vec3> normals,
                  std::span<glm::vec3> irradiance);

// The probes, 1 for each, that irradiance at points within `boxes` is made of: what a volume has to
// hold for objects with these bounding boxes.
// Throws std::invalid_argument for a box that is not finite or turned inside out.
std::vector<std::uint8_t> ProbesNeededIn(const ProbeGrid& grid,
                                         std::span<const std::uint8_t> valid,
                                         std::span<const BoundingBox> boxes);

// Per basis light (sun first, then the sky shapes): what a unit of it makes of map, faces and sky.
// Sky shapes are the transport's, in its order. An empty image or array is black.
struct BasisLights {
  std::vector<EnvironmentBasis> environment;  // Empty images without a survey.
  std::vector<std::vector<glm::vec3>> face_radiosity;
  std::vector<std::vector<glm::vec3>> sky_radiance;  // At ProbeOperator::SkyDirections().
};

// The map route: the synthesised map (and faces, sky) pushed through the operator.
// `environment` is what SynthesiseEnvironment made of `basis` and `lighting`.
IrradianceVolume VolumeFromEnvironment(const ProbeOperator& probes,
                                       const BasisLights& basis,
                                       const RgbImage& environment,
                                       const Lighting& lighting);

// The fast route: operator and basis folded once per sun direction, so that a frame costs
// (1 + shapes) x 9 x 3 multiplications a probe.
// Memory  108 bytes a probe and basis light.
class FoldedVolume {
 public:
  FoldedVolume() = default;
  FoldedVolume(const ProbeOperator& probes, const BasisLights& basis);
  // Folds basis light `light` again (0 is the sun). Throws std::logic_error before anything was
  // folded, std::invalid_argument for another operator, another number of lights, or no such light.
  void Refold(const ProbeOperator& probes, const BasisLights& basis, std::size_t light);
  // Writes into `volume`, which keeps its memory from frame to frame. Where `needed` is not empty,
  // probes that it does not mark (ProbesNeededIn) are not valid in `volume`, so that points
  // elsewhere take the nearest of the others.
  // Throws std::invalid_argument when `lighting` has other sky components than were folded, and for
  // another number of marks than probes.
  void Combine(const Lighting& lighting,
               std::span<const std::uint8_t> needed,
               IrradianceVolume& volume) const;

 private:
  ProbeGrid grid_;
  std::vector<std::uint8_t> valid_;
  BasisProbes probes_of_basis_;  // RGB response.
};

}  // namespace pleinair

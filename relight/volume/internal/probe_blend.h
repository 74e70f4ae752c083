// Which probes a point of the irradiance volume is made of, and what they give there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "relight/volume/probe_operator.h"
#include "scene/spherical_harmonics.h"

namespace pleinair::internal {

// Replaces all eight probes where a grid has no valid one: no light.
inline constexpr std::uint32_t kNoProbe = 0xffffffffu;

// Weights add up to 1; a probe that is named may be read, whatever its weight.
struct ProbeBlend {
  std::array<std::uint32_t, 8> probe{};
  std::array<float, 8> weight{};
};

// Trilinear over the valid ones of the eight probes around the point, weights scaled to add up to
// 1. Where none of them counts, the valid probe nearest to the point (the lowest index of several).
// A point outside the grid is taken to the nearest one of its border first. `position_m` is finite.
ProbeBlend BlendAt(const ProbeGrid& grid,
                   std::span<const std::uint8_t> valid,
                   const glm::vec3& position_m);

// 1 for each probe that BlendAt may name for some point within one of `boxes`; all of them valid.
// A valid probe that is left out could be marked as not valid without a change of any such blend.
std::vector<std::uint8_t> ProbesReadIn(const ProbeGrid& grid,
                                       std::span<const std::uint8_t> valid,
                                       std::span<const BoundingBox> boxes);

// A_l Y_lm(normal): what SH coefficients of incident radiance are multiplied with to give the
// irradiance on a surface (Ramamoorthi and Hanrahan 2001, equation 8).
using IrradianceBasis = std::array<float, kProbeShCoefficients>;
IrradianceBasis IrradianceBasisOf(const glm::vec3& normal);

// Irradiance from the blended coefficients, negative lobes clamped at 0 per channel. Coefficients
// are blended, not irradiances: the clamp then acts once, on what is really there.
glm::vec3 BlendedIrradiance(std::span<const ShRgb> probes,
                            const std::array<std::uint32_t, 8>& probe,
                            const std::array<float, 8>& weight,
                            const IrradianceBasis& basis);

}  // namespace pleinair::internal

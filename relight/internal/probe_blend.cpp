#include "relight/internal/probe_blend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/vector_relational.hpp>

namespace pleinair::internal {
namespace {

constexpr std::size_t kFloats = 3 * kProbeShCoefficients;

std::uint32_t ProbeIndex(const ProbeGrid& grid, const glm::ivec3& cell) {
  return static_cast<std::uint32_t>((cell.z * grid.counts.y + cell.y) * grid.counts.x + cell.x);
}

// Looks through ever larger boxes of probes around the point; a box wider by one can only hold
// nearer ones while its reach is below the best distance.
bool FindNearestValid(const ProbeGrid& grid,
                      std::span<const std::uint8_t> valid,
                      const glm::vec3& position_m,
                      const glm::ivec3& nearest_cell,
                      std::uint32_t& nearest) {
  const float step_m = std::min({grid.spacing_m.x, grid.spacing_m.y, grid.spacing_m.z});
  const glm::vec3 nearest_cell_m = grid.lower_m + grid.spacing_m * glm::vec3(nearest_cell);
  const glm::vec3 outside = position_m - nearest_cell_m;
  const float slack_m =
      std::sqrt(outside.x * outside.x + outside.y * outside.y + outside.z * outside.z);
  const int widest = std::max({grid.counts.x, grid.counts.y, grid.counts.z});
  float best_squared = std::numeric_limits<float>::infinity();
  for (int reach = 0; reach <= widest; ++reach) {
    const float beyond_m = static_cast<float>(reach) * step_m - slack_m;
    if (beyond_m > 0.0f && beyond_m * beyond_m > best_squared) break;
    const glm::ivec3 lower = glm::max(nearest_cell - reach, glm::ivec3(0));
    const glm::ivec3 upper = glm::min(nearest_cell + reach, grid.counts - 1);
    for (int z = lower.z; z <= upper.z; ++z) {
      for (int y = lower.y; y <= upper.y; ++y) {
        // Inside the shell's sides only its two ends are new.
        const bool whole_row =
            std::abs(z - nearest_cell.z) == reach || std::abs(y - nearest_cell.y) == reach;
        const int step = whole_row ? 1 : std::max(1, 2 * reach);
        for (int x = whole_row ? lower.x : nearest_cell.x - reach; x <= upper.x; x += step) {
          if (x < 0) continue;
          const std::uint32_t probe = ProbeIndex(grid, {x, y, z});
          if (valid[probe] == 0) continue;
          const glm::vec3 apart = grid.PositionM(probe) - position_m;
          const float squared = apart.x * apart.x + apart.y * apart.y + apart.z * apart.z;
          if (squared < best_squared || (squared == best_squared && probe < nearest)) {
            best_squared = squared;
            nearest = probe;
          }
        }
      }
    }
  }
  return best_squared < std::numeric_limits<float>::infinity();
}

}  // namespace

ProbeBlend BlendAt(const ProbeGrid& grid,
                   std::span<const std::uint8_t> valid,
                   const glm::vec3& position_m) {
  const glm::vec3 last(grid.counts - 1);
  const glm::vec3 at =
      glm::clamp((position_m - grid.lower_m) / grid.spacing_m, glm::vec3(0.0f), last);
  const glm::ivec3 cell = glm::max(glm::min(glm::ivec3(at), grid.counts - 2), glm::ivec3(0));
  const glm::vec3 share = at - glm::vec3(cell);

  ProbeBlend blend;
  float sum = 0.0f;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const glm::ivec3 step(corner & 1u, (corner >> 1) & 1u, corner >> 2);
    float weight = 1.0f;
    for (glm::length_t axis = 0; axis < 3; ++axis) {
      weight *= step[axis] != 0 ? share[axis] : 1.0f - share[axis];
    }
    // Along an axis with one probe the share is 0, and so is this weight.
    const std::uint32_t probe = ProbeIndex(grid, glm::min(cell + step, grid.counts - 1));
    blend.probe[corner] = probe;
    blend.weight[corner] = valid[probe] != 0 ? weight : 0.0f;
    sum += blend.weight[corner];
  }
  if (sum > 0.0f) {
    for (float& weight : blend.weight) weight /= sum;
    return blend;
  }
  std::uint32_t nearest = 0;
  const glm::ivec3 nearest_cell(at + 0.5f);
  if (FindNearestValid(grid, valid, position_m, nearest_cell, nearest)) {
    blend.probe[0] = nearest;
    blend.weight[0] = 1.0f;
  }
  return blend;
}

IrradianceBasis IrradianceBasisOf(const glm::vec3& normal) {
  IrradianceBasis basis = EvaluateShBasis9(normal);
  std::size_t j = 0;
  for (int band = 0; band < kProbeShBands; ++band) {
    const auto factor = static_cast<float>(CosineLobeFactor(band));
    for (; j < static_cast<std::size_t>(ShCoefficientCount(band + 1)); ++j) basis[j] *= factor;
  }
  return basis;
}

glm::vec3 BlendedIrradiance(std::span<const ShRgb> probes,
                            const std::array<std::uint32_t, 8>& probe,
                            const std::array<float, 8>& weight,
                            const IrradianceBasis& basis) {
  // One float more than there are, so that the last triple can be read as a register of four.
  std::array<float, kFloats + 1> sum{};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const float share = weight[corner];
    if (share == 0.0f) continue;  // Not even read: 0 times what a wrong probe holds need not be 0.
    const float* const coefficients = glm::value_ptr(probes[probe[corner]][0]);
    for (std::size_t j = 0; j < kFloats; ++j) sum[j] += share * coefficients[j];
  }
  std::array<float, 4> irradiance{};
  for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
    for (std::size_t c = 0; c < 4; ++c) irradiance[c] += basis[j] * sum[3 * j + c];
  }
  return {
      std::max(irradiance[0], 0.0f), std::max(irradiance[1], 0.0f), std::max(irradiance[2], 0.0f)};
}

}  // namespace pleinair::internal

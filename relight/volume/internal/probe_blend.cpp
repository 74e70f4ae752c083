#include "relight/volume/internal/probe_blend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "scene/float4.h"

namespace pleinair::internal {
namespace {

// The last coefficient is read with the number before it: behind it another array may begin.
constexpr std::size_t kLast = kProbeShCoefficients - 1;

std::uint32_t ProbeIndex(const ProbeGrid& grid, const glm::ivec3& cell) {
  return static_cast<std::uint32_t>((cell.z * grid.counts.y + cell.y) * grid.counts.x + cell.x);
}

// Looks through ever larger boxes of probes around the point `at` (in cells, inside the grid); a
// box wider by one can only hold nearer ones while its reach is below the best distance.
std::uint32_t NearestValid(const ProbeGrid& grid,
                           std::span<const std::uint8_t> valid,
                           const glm::vec3& at) {
  const glm::ivec3 middle(at + 0.5f);
  const float step_m = std::min({grid.spacing_m.x, grid.spacing_m.y, grid.spacing_m.z});
  const float slack_m = glm::length(grid.spacing_m * (at - glm::vec3(middle)));
  const int widest = std::max({grid.counts.x, grid.counts.y, grid.counts.z});
  std::uint32_t nearest = kNoProbe;
  float best_squared = std::numeric_limits<float>::infinity();
  for (int reach = 0; reach <= widest; ++reach) {
    const float beyond_m = static_cast<float>(reach) * step_m - slack_m;
    if (beyond_m > 0.0f && beyond_m * beyond_m > best_squared) break;
    const glm::ivec3 lower = glm::max(middle - reach, glm::ivec3(0));
    const glm::ivec3 upper = glm::min(middle + reach, grid.counts - 1);
    for (int z = lower.z; z <= upper.z; ++z) {
      for (int y = lower.y; y <= upper.y; ++y) {
        // Inside the shell's sides only its two ends are new.
        const bool whole_row = std::abs(z - middle.z) == reach || std::abs(y - middle.y) == reach;
        const int step = whole_row ? 1 : std::max(1, 2 * reach);
        for (int x = whole_row ? lower.x : middle.x - reach; x <= upper.x; x += step) {
          if (x < 0) continue;
          const std::uint32_t probe = ProbeIndex(grid, {x, y, z});
          if (valid[probe] == 0) continue;
          const glm::vec3 apart_m = grid.spacing_m * (glm::vec3(x, y, z) - at);
          const float squared = glm::dot(apart_m, apart_m);
          if (squared < best_squared || (squared == best_squared && probe < nearest)) {
            best_squared = squared;
            nearest = probe;
          }
        }
      }
    }
  }
  return nearest;
}

// Place in cells of the grid; the border's for a point outside.
glm::vec3 PlaceInGrid(const ProbeGrid& grid, const glm::vec3& position_m) {
  return glm::clamp(
      (position_m - grid.lower_m) / grid.spacing_m, glm::vec3(0.0f), glm::vec3(grid.counts - 1));
}

// The cell's lowest probe; along an axis with one probe there is but cell 0.
glm::ivec3 CellAt(const ProbeGrid& grid, const glm::vec3& at) {
  return glm::max(glm::min(glm::ivec3(at), grid.counts - 2), glm::ivec3(0));
}

// Marks every valid probe that is the nearest one of some point of the cell. A point lies within
// half the diagonal of the middle, so its nearest probe is no farther from the middle than the
// middle's own nearest one and the diagonal.
void MarkStandIns(const ProbeGrid& grid,
                  std::span<const std::uint8_t> valid,
                  const glm::vec3& lower,
                  const glm::vec3& upper,
                  std::span<std::uint8_t> marks) {
  const glm::vec3 middle = 0.5f * (lower + upper);
  const std::uint32_t nearest = NearestValid(grid, valid, middle);
  if (nearest == kNoProbe) return;
  const glm::vec3 middle_m = grid.lower_m + grid.spacing_m * middle;
  constexpr float kRounding = 1.0001f;
  const float reach_m = kRounding * (glm::distance(grid.PositionM(nearest), middle_m) +
                                     glm::length(grid.spacing_m * (upper - lower)));
  for (std::size_t probe = 0; probe < valid.size(); ++probe) {
    if (valid[probe] == 0 || glm::distance(grid.PositionM(probe), middle_m) > reach_m) continue;
    marks[probe] = 1;
  }
}

}  // namespace

ProbeBlend BlendAt(const ProbeGrid& grid,
                   std::span<const std::uint8_t> valid,
                   const glm::vec3& position_m) {
  const glm::vec3 at = PlaceInGrid(grid, position_m);
  const glm::ivec3 cell = CellAt(grid, at);
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
    const auto heaviest = std::max_element(blend.weight.begin(), blend.weight.end());
    const std::uint32_t stand_in =
        blend.probe[static_cast<std::size_t>(heaviest - blend.weight.begin())];
    for (std::size_t corner = 0; corner < 8; ++corner) {
      // What has no weight is not even read: 0 times what a wrong probe holds need not be 0.
      if (blend.weight[corner] == 0.0f) blend.probe[corner] = stand_in;
      blend.weight[corner] /= sum;
    }
    return blend;
  }
  blend.probe.fill(NearestValid(grid, valid, at));
  blend.weight[0] = 1.0f;
  return blend;
}

std::vector<std::uint8_t> ProbesReadIn(const ProbeGrid& grid,
                                       std::span<const std::uint8_t> valid,
                                       std::span<const BoundingBox> boxes) {
  std::vector<std::uint8_t> marks(valid.size(), 0);
  for (const BoundingBox& box : boxes) {
    const glm::ivec3 first = CellAt(grid, PlaceInGrid(grid, box.lower_m));
    const glm::ivec3 last = CellAt(grid, PlaceInGrid(grid, box.upper_m));
    for (int z = first.z; z <= last.z; ++z) {
      for (int y = first.y; y <= last.y; ++y) {
        for (int x = first.x; x <= last.x; ++x) {
          const glm::ivec3 lower(x, y, z);
          const glm::ivec3 upper = glm::min(lower + 1, grid.counts - 1);
          bool all_valid = true;
          for (unsigned corner = 0; corner < 8; ++corner) {
            const glm::ivec3 step(corner & 1u, (corner >> 1) & 1u, corner >> 2);
            const std::uint32_t probe = ProbeIndex(grid, glm::min(lower + step, upper));
            marks[probe] |= valid[probe];
            all_valid = all_valid && valid[probe] != 0;
          }
          if (!all_valid) MarkStandIns(grid, valid, glm::vec3(lower), glm::vec3(upper), marks);
        }
      }
    }
  }
  return marks;
}

IrradianceBasis IrradianceBasisOf(const glm::vec3& normal) {
  static const IrradianceBasis factors = [] {
    IrradianceBasis of_coefficient;
    for (int j = 0, band = 0; j < kProbeShCoefficients; ++j) {
      if (j == ShCoefficientCount(band + 1)) ++band;
      of_coefficient[static_cast<std::size_t>(j)] = static_cast<float>(CosineLobeFactor(band));
    }
    return of_coefficient;
  }();
  IrradianceBasis basis = EvaluateShBasis9(normal);
  for (std::size_t j = 0; j < basis.size(); ++j) basis[j] *= factors[j];
  return basis;
}

glm::vec3 BlendedIrradiance(std::span<const ShRgb> probes,
                            const std::array<std::uint32_t, 8>& probe,
                            const std::array<float, 8>& weight,
                            const IrradianceBasis& basis) {
  if (probe[0] == kNoProbe) return glm::vec3(0.0f);
  // RGB and a lane that is not used. Left to itself the compiler packs the 27 numbers otherwise,
  // and spends twice the time on sorting them out again.
  std::array<Float4, kProbeShCoefficients> sum;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const float share = weight[corner];
    const float* const coefficients = glm::value_ptr(probes[probe[corner]][0]);
    for (std::size_t j = 0; j < kProbeShCoefficients; ++j) {
      const Float4 part = share * LoadFour(coefficients + 3 * j - (j == kLast ? 1 : 0));
      sum[j] = corner == 0 ? part : sum[j] + part;
    }
  }
  Float4 irradiance = basis[0] * sum[0];
  for (std::size_t j = 1; j < kLast; ++j) irradiance += basis[j] * sum[j];
  const Float4 last = basis[kLast] * sum[kLast];
  return {std::max(irradiance[0] + last[1], 0.0f),
          std::max(irradiance[1] + last[2], 0.0f),
          std::max(irradiance[2] + last[3], 0.0f)};
}

}  // namespace pleinair::internal

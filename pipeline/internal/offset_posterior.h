// One offset from many tiles that each say something of it, some of them wrongly.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/internal/shadow_pixels.h"

namespace pleinair {

// The evidence of one tile of one picture.
struct OffsetUnit {
  std::size_t frame = 0;
  std::size_t block = 0;               // Block of the picture: neighbouring tiles err together.
  std::vector<double> log_likelihood;  // For each candidate, up to a constant.
};

struct OffsetEstimate {
  double offset_rad = 0.0;
  // Deviation of the posterior: how closely the tiles agree, with their own scatter.
  double curvature_stddev_rad = 0.0;
  // The larger deviation by leaving out one frame after the other, and one block of the picture
  // after the other. Includes errors that neighbours and frames share.
  double spread_stddev_rad = 0.0;
};

struct OffsetPosterior {
  OffsetEstimate all;
  std::vector<OffsetEstimate> frames;  // By each frame alone.
  std::size_t peak = 0;                // The likeliest candidate of all frames together.
};

// Model: a tile sees offset + e, with e normal with an unknown standard deviation that all tiles
// share (the mesh's errors). An unknown share of the tiles sees an arbitrary offset (shadows of
// what the mesh lacks). Both unknowns are integrated over, and the offset over the grid.
OffsetPosterior CombineUnits(std::span<const OffsetUnit> units,
                             std::size_t frames,
                             const OffsetGrid& grid);

}  // namespace pleinair

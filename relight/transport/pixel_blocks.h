// Rays spared where the corners of a block of pixels agree.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <tbb/parallel_for.h>

namespace pleinair {

struct PixelBlocks {
  int width = 0;
  int height = 0;
  int block_px = 1;  // Side of a block; blocks share their corners. 1: each pixel is cast.
};

// Upper left, upper right, lower left and lower right: indices of pixels.
using BlockCorners = std::array<std::size_t, 4>;

// First casts the corners of all blocks, the last row and column among them; then fills what lies
// between corners that agree, and casts the rest.
//
// cast_row(y, wanted)       casts the pixels x of row y with wanted[x] != 0.
// agree(corners)            whether what lies between may be filled.
// fill(x, y, corners)       false where this pixel has to be cast after all.
//
// Rows are taken in parallel; none but its own pixels, without corners, may be written for a row
// after the first pass.
template <class CastRow, class Agree, class Fill>
void CastInBlocks(const PixelBlocks& blocks,
                  const CastRow& cast_row,
                  const Agree& agree,
                  const Fill& fill) {
  const int side = std::max(blocks.block_px, 1);
  const auto at_corner = [side](int at, int size) { return at % side == 0 || at == size - 1; };
  std::vector<std::uint8_t> corner_columns(static_cast<std::size_t>(blocks.width), 0);
  for (int x = 0; x < blocks.width; ++x) {
    corner_columns[static_cast<std::size_t>(x)] = at_corner(x, blocks.width) ? 1 : 0;
  }
  tbb::parallel_for(0, blocks.height, [&](int y) {
    if (at_corner(y, blocks.height)) cast_row(y, corner_columns);
  });
  if (side == 1) return;
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(blocks.width) +
           static_cast<std::size_t>(x);
  };
  tbb::parallel_for(0, blocks.height, [&](int y) {
    const int top = y / side * side;
    const int bottom = std::min(top + side, blocks.height - 1);
    const bool has_corners = at_corner(y, blocks.height);
    std::vector<std::uint8_t> wanted(static_cast<std::size_t>(blocks.width), 0);
    for (int left = 0; left < blocks.width; left += side) {
      const int right = std::min(left + side, blocks.width - 1);
      const BlockCorners corners{
          index(left, top), index(right, top), index(left, bottom), index(right, bottom)};
      const bool agreed = agree(corners);
      for (int x = left; x < std::min(left + side, blocks.width); ++x) {
        if (has_corners && corner_columns[static_cast<std::size_t>(x)] != 0) continue;
        if (!agreed || !fill(x, y, corners)) wanted[static_cast<std::size_t>(x)] = 1;
      }
    }
    cast_row(y, wanted);
  });
}

}  // namespace pleinair

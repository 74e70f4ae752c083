#include "relight/view_part.h"

#include <algorithm>
#include <cstddef>

#include <tbb/parallel_for.h>

#include "relight/transport/patch_scene.h"

namespace pleinair {
namespace {

constexpr int kMarginPx = 8;

// Columns or rows [first, end) of blocks.
struct Run {
  int first = 0;
  int end = 0;
};

// Those that hold pixels lower .. upper - 1. The last one may be a pixel longer than its side.
Run BlocksWith(int lower, int upper, int side_px, int blocks) {
  return {std::min(lower / side_px, blocks - 1), std::min((upper - 1) / side_px + 1, blocks)};
}

}  // namespace

std::vector<std::uint8_t> BlocksLookedAt(const ViewPart& part,
                                         const PixelBlocks& blocks,
                                         const Image<std::int32_t>& side,
                                         const Image<glm::vec3>& position_m) {
  std::vector<std::uint8_t> is_chosen(blocks.Count(), 0);
  for (const PixelRect& wanted : part.rects) {
    const PixelRect rect{glm::max(wanted.lower, glm::ivec2(0)),
                         glm::min(wanted.upper, glm::ivec2(blocks.Width(), blocks.Height()))};
    if (rect.Empty()) continue;
    const Run columns = BlocksWith(rect.lower.x, rect.upper.x, blocks.SidePx(), blocks.Columns());
    const Run rows = BlocksWith(rect.lower.y, rect.upper.y, blocks.SidePx(), blocks.Rows());
    for (int y = rows.first; y < rows.end; ++y) {
      const auto row = is_chosen.begin() + static_cast<std::ptrdiff_t>(blocks.Index(0, y));
      std::fill(row + columns.first, row + columns.end, std::uint8_t{1});
    }
  }
  if (!part.looks_at) return is_chosen;
  // Around each corner, the blocks that it is a corner of and those within the margin of it.
  const int reach = 1 + (kMarginPx + blocks.SidePx() - 1) / blocks.SidePx();
  const auto corners = static_cast<std::size_t>(blocks.Columns()) + 1;
  std::vector<std::uint8_t> along_row(blocks.Count() + static_cast<std::size_t>(blocks.Columns()),
                                      0);
  tbb::parallel_for(0, blocks.Rows() + 1, [&](int row) {
    const std::size_t first = static_cast<std::size_t>(row) * (corners - 1);
    for (int column = 0; column <= blocks.Columns(); ++column) {
      const std::size_t pixel = side.Index(blocks.CornerX(column), blocks.CornerY(row));
      if (side.pixels[pixel] == PatchScene::kSky ||
          !part.looks_at(side.pixels[pixel], position_m.pixels[pixel])) {
        continue;
      }
      for (int x = std::max(column - reach, 0); x < std::min(column + reach, blocks.Columns());
           ++x) {
        along_row[first + static_cast<std::size_t>(x)] = 1;
      }
    }
  });
  tbb::parallel_for(0, blocks.Rows(), [&](int row) {
    for (int corner = std::max(row + 1 - reach, 0); corner <= std::min(row + reach, blocks.Rows());
         ++corner) {
      for (int x = 0; x < blocks.Columns(); ++x) {
        is_chosen[blocks.Index(x, row)] |=
            along_row[static_cast<std::size_t>(corner) * (corners - 1) +
                      static_cast<std::size_t>(x)];
      }
    }
  });
  return is_chosen;
}

}  // namespace pleinair

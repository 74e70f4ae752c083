#include "relight/internal/looked_at_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/transport/patch_scene.h"
#include "relight/transport/same_plane.h"

namespace pleinair {
namespace {

// Columns or rows [first, end) of blocks.
struct Run {
  int first = 0;
  int end = 0;
};

// Those that hold pixels lower .. upper - 1. The last one may be a pixel longer than its side.
Run BlocksWith(int lower, int upper, int side_px, int blocks) {
  return {std::min(lower / side_px, blocks - 1), std::min((upper - 1) / side_px + 1, blocks)};
}

void ChooseRect(const PixelRect& wanted,
                const PixelBlocks& blocks,
                std::vector<std::uint8_t>& is_chosen) {
  const PixelRect rect{glm::max(wanted.lower, glm::ivec2(0)),
                       glm::min(wanted.upper, glm::ivec2(blocks.Width(), blocks.Height()))};
  if (rect.Empty()) return;
  const Run columns = BlocksWith(rect.lower.x, rect.upper.x, blocks.SidePx(), blocks.Columns());
  const Run rows = BlocksWith(rect.lower.y, rect.upper.y, blocks.SidePx(), blocks.Rows());
  for (int y = rows.first; y < rows.end; ++y) {
    const auto row = is_chosen.begin() + static_cast<std::ptrdiff_t>(blocks.Index(0, y));
    std::fill(row + columns.first, row + columns.end, std::uint8_t{1});
  }
}

// How far from what a corner shows a place may be that no corner shows: what its plane has as far
// as the next corners, and at least a block that is seen at a right angle.
class CornerReach {
 public:
  CornerReach(const PixelBlocks& blocks, const SurfaceView& view)
      : blocks_(blocks),
        view_(view),
        eye_m_(view.camera.CentreWorldM()),
        block_over_range_(static_cast<float>(blocks.SidePx() / view.camera.intrinsics.fx_px)) {}

  float ReachM(int column, int row) const {
    const std::size_t own = PixelOf(column, row);
    const glm::vec3& own_m = view_.position_world_m.pixels[own];
    const float range_m = glm::distance(own_m, eye_m_);
    float reach_m = block_over_range_ * range_m;
    constexpr std::array<std::array<int, 2>, 4> kBeside{{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    for (const auto& [dx, dy] : kBeside) {
      const int x = column + dx;
      const int y = row + dy;
      if (x < 0 || y < 0 || x > blocks_.Columns() || y > blocks_.Rows()) continue;
      const std::size_t beside = PixelOf(x, y);
      const glm::vec3& beside_m = view_.position_world_m.pixels[beside];
      if (SamePlane(own_m,
                    view_.normal_world.pixels[own],
                    beside_m,
                    view_.normal_world.pixels[beside],
                    range_m)) {
        reach_m = std::max(reach_m, glm::distance(own_m, beside_m));
      }
    }
    return reach_m;
  }

 private:
  std::size_t PixelOf(int column, int row) const {
    return blocks_.PixelIndex(blocks_.CornerX(column), blocks_.CornerY(row));
  }

  const PixelBlocks& blocks_;
  const SurfaceView& view_;
  glm::vec3 eye_m_;
  float block_over_range_;
};

}  // namespace

std::vector<std::uint8_t> LookedAtBlocks(const ViewPart& part,
                                         const PixelBlocks& blocks,
                                         const SurfaceView& view,
                                         const Image<std::int32_t>& side) {
  std::vector<std::uint8_t> is_chosen(blocks.Count(), 0);
  for (const PixelRect& rect : part.rects) ChooseRect(rect, blocks, is_chosen);
  if (!part.places.any_near) return is_chosen;
  // Blocks within this many of a corner: those that meet in it are the first.
  const int reach = 1 + (part.places.margin_px + blocks.SidePx() - 1) / blocks.SidePx();
  const CornerReach corners(blocks, view);
  // Per row of corners, its blocks along it; then those along columns.
  const auto columns = static_cast<std::size_t>(blocks.Columns());
  std::vector<std::uint8_t> along_row(blocks.Count() + columns, 0);
  tbb::parallel_for(0, blocks.Rows() + 1, [&](int row) {
    const auto begin = along_row.begin() + static_cast<std::ptrdiff_t>(row) * blocks.Columns();
    for (int column = 0; column <= blocks.Columns(); ++column) {
      const std::size_t pixel = blocks.PixelIndex(blocks.CornerX(column), blocks.CornerY(row));
      if (side.pixels[pixel] == PatchScene::kSky ||
          !part.places.any_near(side.pixels[pixel],
                                view.position_world_m.pixels[pixel],
                                corners.ReachM(column, row))) {
        continue;
      }
      std::fill(begin + std::max(column - reach, 0),
                begin + std::min(column + reach, blocks.Columns()),
                std::uint8_t{1});
    }
  });
  tbb::parallel_for(0, blocks.Rows(), [&](int row) {
    const int last = std::min(row + reach, blocks.Rows());
    for (int corner = std::max(row + 1 - reach, 0); corner <= last; ++corner) {
      for (int x = 0; x < blocks.Columns(); ++x) {
        is_chosen[blocks.Index(x, row)] |=
            along_row[static_cast<std::size_t>(corner) * columns + static_cast<std::size_t>(x)];
      }
    }
  });
  return is_chosen;
}

}  // namespace pleinair

#include "relight/transport/plane_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace pleinair {
namespace {

int ValidatedBlock(int block_px) {
  if (block_px < 1) {
    throw std::invalid_argument("receiver_block_px is " + std::to_string(block_px) +
                                ": expected at least 1");
  }
  return block_px;
}

}  // namespace

PlaneBlocks::PlaneBlocks(const SurfaceView& view, const glm::vec3& origin_m, const Options& options)
    : view_(view),
      origin_m_(origin_m),
      block_px_(ValidatedBlock(options.block_px)),
      wraps_x_(options.wraps_x),
      columns_((view.Width() + block_px_ - 1) / block_px_),
      rows_((view.Height() + block_px_ - 1) / block_px_),
      across_(AlongSide(view.Width(), block_px_)),
      down_(AlongSide(view.Height(), block_px_)),
      planes_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
  tbb::parallel_for(0, rows_, [&](int row) {
    Scratch scratch;
    for (int column = 0; column < columns_; ++column) {
      Collect(column, row, options.candidates, scratch);
    }
  });
  for (std::vector<Plane>& block : planes_) {
    for (Plane& plane : block) {
      plane.receiver = static_cast<std::uint32_t>(receivers_.size());
      receivers_.push_back(
          {view_.position_world_m.pixels[plane.pixel], view_.normal_world.pixels[plane.pixel]});
      receiver_pixels_.push_back(plane.pixel);
    }
  }
}

std::vector<PlaneBlocks::Along> PlaneBlocks::AlongSide(int pixels, int block_px) {
  std::vector<Along> along(static_cast<std::size_t>(std::max(pixels, 0)));
  for (int i = 0; i < pixels; ++i) {
    const double at = (i + 0.5) / block_px - 0.5;
    const int first = static_cast<int>(std::floor(at));
    along[static_cast<std::size_t>(i)] = {first, at - first};
  }
  return along;
}

void PlaneBlocks::Collect(int column, int row, const Gray8Image* candidates, Scratch& scratch) {
  scratch.members.clear();
  scratch.middles.clear();
  std::vector<Plane> block;
  for (int y = row * block_px_; y < std::min((row + 1) * block_px_, view_.Height()); ++y) {
    for (int x = column * block_px_; x < std::min((column + 1) * block_px_, view_.Width()); ++x) {
      const std::size_t pixel = view_.region.Index(x, y);
      if (candidates != nullptr && candidates->pixels[pixel] == 0) continue;
      if (view_.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      const Plane* const found = Find(pixel, RangeM(pixel), block);
      const std::size_t plane =
          found != nullptr ? static_cast<std::size_t>(found - block.data()) : block.size();
      if (found == nullptr) {
        block.push_back({pixel, 0});
        scratch.middles.emplace_back();
      }
      scratch.members.push_back({{x, y}, plane});
      scratch.middles[plane].sum += glm::dvec2(x, y);
      ++scratch.middles[plane].count;
    }
  }
  for (Scratch::Middle& middle : scratch.middles) {
    middle.sum /= static_cast<double>(middle.count);
    middle.nearest = std::numeric_limits<double>::infinity();
  }
  for (const auto& [pixel, plane] : scratch.members) {
    Scratch::Middle& middle = scratch.middles[plane];
    const glm::dvec2 apart = glm::dvec2(pixel) - middle.sum;
    if (!(glm::dot(apart, apart) < middle.nearest)) continue;
    middle.nearest = glm::dot(apart, apart);
    block[plane].pixel = view_.region.Index(pixel.x, pixel.y);
  }
  planes_[Block(column, row)] = std::move(block);
}

}  // namespace pleinair

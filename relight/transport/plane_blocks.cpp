#include "relight/transport/plane_blocks.h"

#include <algorithm>
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
      planes_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
  tbb::parallel_for(0, rows_, [&](int row) {
    for (int column = 0; column < columns_; ++column) Collect(column, row, options.candidates);
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

void PlaneBlocks::Collect(int column, int row, const Gray8Image* candidates) {
  std::vector<std::vector<glm::ivec2>> clusters;  // Per plane of the block, its pixels.
  std::vector<Plane> block;
  for (int y = row * block_px_; y < std::min((row + 1) * block_px_, view_.Height()); ++y) {
    for (int x = column * block_px_; x < std::min((column + 1) * block_px_, view_.Width()); ++x) {
      const std::size_t pixel = view_.region.Index(x, y);
      if (view_.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      if (candidates != nullptr && candidates->pixels[pixel] == 0) continue;
      const Plane* found = Find(pixel, RangeM(pixel), block);
      if (found == nullptr) {
        block.push_back({pixel, 0});
        clusters.push_back({{x, y}});
      } else {
        clusters[static_cast<std::size_t>(found - block.data())].emplace_back(x, y);
      }
    }
  }
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    glm::dvec2 middle(0.0);
    for (const glm::ivec2& pixel : clusters[i]) middle += glm::dvec2(pixel);
    middle /= static_cast<double>(clusters[i].size());
    double nearest = std::numeric_limits<double>::infinity();
    for (const glm::ivec2& pixel : clusters[i]) {
      const glm::dvec2 apart = glm::dvec2(pixel) - middle;
      if (glm::dot(apart, apart) < nearest) {
        nearest = glm::dot(apart, apart);
        block[i].pixel = view_.region.Index(pixel.x, pixel.y);
      }
    }
  }
  planes_[Block(column, row)] = std::move(block);
}

}  // namespace pleinair

#include "relight/transport/surface_gather.h"

#include <algorithm>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/transport/pixel_blocks.h"
#include "relight/transport/plane_blocks.h"

namespace pleinair {

SurfaceGather::SurfaceGather(const PatchScene& scene,
                             const ViewRays& rays,
                             const SurfaceView& view,
                             int block_px,
                             const GatherOptions& options) {
  const PlaneBlocks planes(
      view, rays.origin_m, {.block_px = block_px, .wraps_x = rays.wraps_x, .candidates = nullptr});
  rays_ = std::make_shared<const GatheredRays>(scene, planes.Receivers(), options);

  entry_begin_.assign(1, 0);
  entry_begin_.reserve(view.region.pixels.size() + 1);
  for (int y = 0; y < rays.height; ++y) {
    for (int x = 0; x < rays.width; ++x) {
      const std::size_t first = entries_.size();
      if (view.region.At(x, y) != SurfaceView::kNoRegion) {
        double sum = 0.0;
        planes.ForPixel(x, y, [&](std::uint32_t receiver, double weight) {
          entries_.push_back({receiver, static_cast<float>(weight)});
          sum += weight;
        });
        // The pixel's own block always has its plane, with a weight of a quarter at least.
        for (std::size_t i = first; i < entries_.size(); ++i) {
          entries_[i].weight = static_cast<float>(entries_[i].weight / sum);
        }
      }
      entry_begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
    }
  }
}

void SurfaceGather::Blend(std::span<const glm::vec3> at_receivers,
                          std::vector<glm::vec3>& at_pixels) const {
  at_pixels.resize(PixelCount());
  constexpr std::size_t kBlock = 4096;
  tbb::parallel_for(std::size_t{0}, (PixelCount() + kBlock - 1) / kBlock, [&](std::size_t block) {
    for (std::size_t i = block * kBlock; i < std::min(PixelCount(), (block + 1) * kBlock); ++i) {
      glm::vec3 sum(0.0f);
      for (std::uint32_t k = entry_begin_[i]; k < entry_begin_[i + 1]; ++k) {
        sum += entries_[k].weight * at_receivers[entries_[k].receiver];
      }
      at_pixels[i] = sum;
    }
  });
}

GrayImage SunVisibility(const RayCaster& caster, const SunDisc& disc, const SurfaceView& view) {
  GrayImage visibility;
  SunVisibilityInBlocks(
      caster, disc, {PixelBlocks(view.Width(), view.Height(), 1), {}}, view, visibility);
  return visibility;
}

void SunVisibilityInBlocks(const RayCaster& caster,
                           const SunDisc& disc,
                           const PlanarBlocks& planar,
                           const SurfaceView& view,
                           GrayImage& visibility) {
  const PixelBlocks& blocks = planar.blocks;
  SizeFor(blocks, visibility);
  const auto cast_row = [&](int y, std::span<const std::uint8_t> wanted) {
    std::vector<Receiver> receivers;
    std::vector<std::size_t> pixels;
    for (int x = 0; x < view.Width(); ++x) {
      if (wanted[static_cast<std::size_t>(x)] == 0) continue;
      const std::size_t pixel = view.region.Index(x, y);
      visibility.pixels[pixel] = 0.0f;
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      receivers.push_back({view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]});
      pixels.push_back(pixel);
    }
    const std::vector<float> shares = disc.Visibility(caster, receivers);
    for (std::size_t i = 0; i < pixels.size(); ++i) visibility.pixels[pixels[i]] = shares[i];
  };
  const auto fill_between = [&](int column, int row, const PixelBlock& block) {
    if (planar.is_planar[blocks.Index(column, row)] == 0) return false;
    const std::array<std::size_t, 4> corners = blocks.Corners(block);
    const float share = visibility.pixels[corners[0]];
    const bool is_uniform = (share == 0.0f || share == 1.0f) &&
                            std::all_of(corners.begin() + 1, corners.end(), [&](std::size_t at) {
                              return visibility.pixels[at] == share;
                            });
    if (!is_uniform) return false;
    block.ForPixelsBetween([&](int x, int y) { visibility.At(x, y) = share; });
    return true;
  };
  ForBlocks(
      blocks, cast_row, fill_between, [&](std::size_t pixel) { visibility.pixels[pixel] = 0.0f; });
}

}  // namespace pleinair

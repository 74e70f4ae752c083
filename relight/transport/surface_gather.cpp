#include "relight/transport/surface_gather.h"

#include <algorithm>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/transport/pixel_blocks.h"
#include "relight/transport/plane_blocks.h"
#include "relight/transport/same_plane.h"

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

GrayImage SunVisibility(const RayCaster& caster,
                        const SunDisc& disc,
                        int block_px,
                        const SurfaceView& view) {
  GrayImage sun_visibility(view.Width(), view.Height(), 0.0f);
  const auto cast_row = [&](int y, std::span<const std::uint8_t> wanted) {
    std::vector<Receiver> receivers;
    std::vector<std::size_t> pixels;
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion ||
          wanted[static_cast<std::size_t>(x)] == 0) {
        continue;
      }
      receivers.push_back({view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]});
      pixels.push_back(pixel);
    }
    const std::vector<float> visibility = disc.Visibility(caster, receivers);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      sun_visibility.pixels[pixels[i]] = visibility[i];
    }
  };
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  const auto on_plane_of = [&](std::size_t pixel, std::size_t corner) {
    return view.region.pixels[pixel] == view.region.pixels[corner] &&
           SamePlane(view.position_world_m.pixels[pixel],
                     view.normal_world.pixels[pixel],
                     view.position_world_m.pixels[corner],
                     view.normal_world.pixels[corner],
                     glm::distance(eye_m, view.position_world_m.pixels[corner]));
  };
  const auto agree = [&](const BlockCorners& corners) {
    const float visibility = sun_visibility.pixels[corners[0]];
    return (visibility == 0.0f || visibility == 1.0f) &&
           std::all_of(corners.begin() + 1, corners.end(), [&](std::size_t corner) {
             return sun_visibility.pixels[corner] == visibility && on_plane_of(corner, corners[0]);
           });
  };
  const auto fill = [&](int x, int y, const BlockCorners& corners) {
    const std::size_t pixel = view.region.Index(x, y);
    if (!on_plane_of(pixel, corners[0])) return false;
    sun_visibility.pixels[pixel] = sun_visibility.pixels[corners[0]];
    return true;
  };
  CastInBlocks({view.Width(), view.Height(), block_px}, cast_row, agree, fill);
  return sun_visibility;
}

}  // namespace pleinair

#include "relight/internal/surface_gather.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/internal/same_plane.h"

namespace pleinair {
namespace {

// What a block shows of one plane: its receiver stands at `pixel`.
struct BlockPlane {
  std::size_t pixel = 0;
  std::uint32_t receiver = 0;
};

class BlockPlanes {
 public:
  BlockPlanes(const ViewRays& rays, const SurfaceView& view, int block_px)
      : rays_(rays),
        view_(view),
        block_px_(block_px),
        columns_((rays.width + block_px - 1) / block_px),
        rows_((rays.height + block_px - 1) / block_px),
        planes_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
    tbb::parallel_for(0, rows_, [this](int row) {
      for (int column = 0; column < columns_; ++column) Collect(column, row);
    });
    for (std::vector<BlockPlane>& block : planes_) {
      for (BlockPlane& plane : block) {
        plane.receiver = static_cast<std::uint32_t>(receivers_.size());
        receivers_.push_back(
            {view_.position_world_m.pixels[plane.pixel], view_.normal_world.pixels[plane.pixel]});
      }
    }
  }

  const std::vector<Receiver>& Receivers() const { return receivers_; }

  template <class Visit>  // visit(receiver, weight)
  void ForPixel(int x, int y, const Visit& visit) const {
    const double u = (x + 0.5) / block_px_ - 0.5;
    const double v = (y + 0.5) / block_px_ - 0.5;
    const int left = static_cast<int>(std::floor(u));
    const int top = static_cast<int>(std::floor(v));
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        const double weight =
            (dx == 0 ? 1.0 - (u - left) : u - left) * (dy == 0 ? 1.0 - (v - top) : v - top);
        if (!(weight > 0.0)) continue;
        const int row = top + dy;
        int column = left + dx;
        if (row < 0 || row >= rows_) continue;
        if (rays_.wraps_x) column = (column + columns_) % columns_;
        if (column < 0 || column >= columns_) continue;
        if (const BlockPlane* plane = Find(view_.region.Index(x, y), Block(column, row))) {
          visit(plane->receiver, weight);
        }
      }
    }
  }

 private:
  const std::vector<BlockPlane>& Block(int column, int row) const {
    return planes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(column)];
  }

  const BlockPlane* Find(std::size_t pixel, const std::vector<BlockPlane>& block) const {
    const glm::vec3& position = view_.position_world_m.pixels[pixel];
    const float range_m = glm::distance(position, rays_.origin_m);
    for (const BlockPlane& plane : block) {
      if (SamePlane(position,
                    view_.normal_world.pixels[pixel],
                    view_.position_world_m.pixels[plane.pixel],
                    view_.normal_world.pixels[plane.pixel],
                    range_m)) {
        return &plane;
      }
    }
    return nullptr;
  }

  void Collect(int column, int row) {
    struct Cluster {
      BlockPlane plane;
      std::vector<glm::ivec2> pixels;
    };
    std::vector<Cluster> clusters;
    std::vector<BlockPlane> block;
    for (int y = row * block_px_; y < std::min((row + 1) * block_px_, rays_.height); ++y) {
      for (int x = column * block_px_; x < std::min((column + 1) * block_px_, rays_.width); ++x) {
        const std::size_t pixel = view_.region.Index(x, y);
        if (view_.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
        const BlockPlane* found = Find(pixel, block);
        if (found == nullptr) {
          block.push_back({pixel, 0});
          clusters.push_back({{pixel, 0}, {{x, y}}});
        } else {
          clusters[static_cast<std::size_t>(found - block.data())].pixels.emplace_back(x, y);
        }
      }
    }
    for (std::size_t i = 0; i < clusters.size(); ++i) {
      glm::dvec2 middle(0.0);
      for (const glm::ivec2& pixel : clusters[i].pixels) middle += glm::dvec2(pixel);
      middle /= static_cast<double>(clusters[i].pixels.size());
      double nearest = std::numeric_limits<double>::infinity();
      for (const glm::ivec2& pixel : clusters[i].pixels) {
        const glm::dvec2 apart = glm::dvec2(pixel) - middle;
        if (glm::dot(apart, apart) < nearest) {
          nearest = glm::dot(apart, apart);
          block[i].pixel = view_.region.Index(pixel.x, pixel.y);
        }
      }
    }
    planes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
            static_cast<std::size_t>(column)] = std::move(block);
  }

  const ViewRays& rays_;
  const SurfaceView& view_;
  int block_px_;
  int columns_;
  int rows_;
  std::vector<std::vector<BlockPlane>> planes_;  // Per block, row-major.
  std::vector<Receiver> receivers_;
};

}  // namespace

Image<std::int32_t> CastGeometry(const PatchScene& scene, const ViewRays& rays, SurfaceView& view) {
  view.region_names = scene.mesh.group_names;
  view.region = Image<std::int32_t>(rays.width, rays.height, SurfaceView::kNoRegion);
  view.position_world_m = RgbImage(rays.width, rays.height, glm::vec3(0.0f));
  view.normal_world = RgbImage(rays.width, rays.height, glm::vec3(0.0f));
  Image<std::int32_t> face(rays.width, rays.height, PatchScene::kSky);
  tbb::parallel_for(0, rays.height, [&](int y) {
    for (int x = 0; x < rays.width; ++x) {
      const std::optional<glm::vec3> direction = rays.direction(x, y);
      if (!direction) continue;
      const auto hit = scene.caster.Intersect(rays.origin_m, *direction);
      if (!hit) continue;
      const std::size_t pixel = view.region.Index(x, y);
      face.pixels[pixel] = PatchScene::FaceOfHit(*hit, *direction);
      view.region.pixels[pixel] =
          static_cast<std::int32_t>(scene.mesh.triangle_group[hit->triangle]);
      view.position_world_m.pixels[pixel] = hit->position_m;
      view.normal_world.pixels[pixel] =
          face.pixels[pixel] % 2 == 0 ? hit->geometric_normal : -hit->geometric_normal;
    }
  });
  return face;
}

SurfaceGather::SurfaceGather(const PatchScene& scene,
                             const ViewRays& rays,
                             const SurfaceView& view,
                             int block_px,
                             const GatherOptions& options) {
  if (block_px < 1) {
    throw std::invalid_argument("receiver_block_px is " + std::to_string(block_px) +
                                ": expected at least 1");
  }
  const BlockPlanes planes(rays, view, block_px);
  rays_ = GatheredRays(scene, planes.Receivers(), options);

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

void CastSunVisibility(const RayCaster& caster, const SunDisc& disc, SurfaceView& view) {
  view.sun_visibility = GrayImage(view.Width(), view.Height(), 0.0f);
  tbb::parallel_for(0, view.Height(), [&](int y) {
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion) continue;
      view.sun_visibility.pixels[pixel] = disc.Visibility(
          caster, {view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]});
    }
  });
}

}  // namespace pleinair

#include "relight/transport/surface_gather.h"

#include <algorithm>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/transport/plane_blocks.h"
#include "relight/transport/same_plane.h"

namespace pleinair {

Image<std::int32_t> CastGeometry(const PatchScene& scene, const ViewRays& rays, SurfaceView& view) {
  view.region_names = scene.mesh.group_names;
  view.region = Image<std::int32_t>(rays.width, rays.height, SurfaceView::kNoRegion);
  view.position_world_m = RgbImage(rays.width, rays.height, glm::vec3(0.0f));
  view.normal_world = RgbImage(rays.width, rays.height, glm::vec3(0.0f));
  Image<std::int32_t> face(rays.width, rays.height, PatchScene::kSky);
  const auto width = static_cast<std::size_t>(rays.width);
  const std::vector<glm::vec3> origins_m(width, rays.origin_m);
  tbb::parallel_for(0, rays.height, [&](int y) {
    std::vector<glm::vec3> directions;
    std::vector<int> columns;
    for (int x = 0; x < rays.width; ++x) {
      const std::optional<glm::vec3> direction = rays.direction(x, y);
      if (!direction) continue;
      directions.push_back(*direction);
      columns.push_back(x);
    }
    std::vector<std::optional<RayHit>> hits(directions.size());
    scene.caster.Intersect(origins_m.data(), directions.data(), directions.size(), hits.data());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (!hits[i]) continue;
      const std::size_t pixel = view.region.Index(columns[i], y);
      face.pixels[pixel] = PatchScene::FaceOfHit(*hits[i], directions[i]);
      view.region.pixels[pixel] =
          static_cast<std::int32_t>(scene.mesh.triangle_group[hits[i]->triangle]);
      view.position_world_m.pixels[pixel] = hits[i]->position_m;
      view.normal_world.pixels[pixel] =
          face.pixels[pixel] % 2 == 0 ? hits[i]->geometric_normal : -hits[i]->geometric_normal;
    }
  });
  return face;
}

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

SurfaceGather::SurfaceGather(const CornerGather& corners,
                             const PatchScene& scene,
                             const Image<std::int32_t>& face,
                             const SurfaceView& view)
    : rays_(corners.Rays()),
      entry_begin_(face.pixels.size() + 1),
      entries_(3 * face.pixels.size(), Entry{0, 0.0f}) {
  // Three a pixel, of no weight where it shows no surface.
  for (std::size_t i = 0; i < entry_begin_.size(); ++i) {
    entry_begin_[i] = static_cast<std::uint32_t>(3 * i);
  }
  tbb::parallel_for(0, face.height, [&](int y) {
    for (int x = 0; x < face.width; ++x) {
      const std::size_t pixel = face.Index(x, y);
      if (face.pixels[pixel] == PatchScene::kSky) continue;
      const auto around = corners.Lattice().Around(
          scene, static_cast<std::size_t>(face.pixels[pixel]), view.position_world_m.pixels[pixel]);
      for (std::size_t k = 0; k < 3; ++k) {
        entries_[3 * pixel + k] = {around[k].receiver, around[k].weight};
      }
    }
  });
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
  // Casts the pixels of row y that `wanted` says.
  const auto cast_row = [&](int y, const auto& wanted) {
    std::vector<Receiver> receivers;
    std::vector<std::size_t> pixels;
    for (int x = 0; x < view.Width(); ++x) {
      const std::size_t pixel = view.region.Index(x, y);
      if (view.region.pixels[pixel] == SurfaceView::kNoRegion || !wanted(x)) continue;
      receivers.push_back({view.position_world_m.pixels[pixel], view.normal_world.pixels[pixel]});
      pixels.push_back(pixel);
    }
    const std::vector<float> visibility = disc.Visibility(caster, receivers);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      sun_visibility.pixels[pixels[i]] = visibility[i];
    }
  };
  if (block_px <= 1) {
    tbb::parallel_for(0, view.Height(), [&](int y) { cast_row(y, [](int) { return true; }); });
    return sun_visibility;
  }
  // The corners of blocks first, the last row and column among them.
  const auto at_corner = [block_px](int at, int size) {
    return at % block_px == 0 || at == size - 1;
  };
  tbb::parallel_for(0, view.Height(), [&](int y) {
    if (!at_corner(y, view.Height())) return;
    cast_row(y, [&](int x) { return at_corner(x, view.Width()); });
  });
  // Then what lies on the plane of a block's four corners that agree, and the rest by rays.
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  const auto on_plane_of = [&](std::size_t pixel, std::size_t corner) {
    return view.region.pixels[pixel] == view.region.pixels[corner] &&
           SamePlane(view.position_world_m.pixels[pixel],
                     view.normal_world.pixels[pixel],
                     view.position_world_m.pixels[corner],
                     view.normal_world.pixels[corner],
                     glm::distance(eye_m, view.position_world_m.pixels[corner]));
  };
  const GrayImage corners = sun_visibility;
  tbb::parallel_for(0, view.Height(), [&](int y) {
    const int top = y / block_px * block_px;
    const int bottom = std::min(top + block_px, view.Height() - 1);
    std::vector<std::uint8_t> wanted(static_cast<std::size_t>(view.Width()), 0);
    for (int left = 0; left < view.Width(); left += block_px) {
      const int right = std::min(left + block_px, view.Width() - 1);
      const std::size_t first = view.region.Index(left, top);
      const float visibility = corners.pixels[first];
      bool agree = visibility == 0.0f || visibility == 1.0f;
      for (const auto& [x, row] : {std::pair{right, top}, {left, bottom}, {right, bottom}}) {
        const std::size_t corner = view.region.Index(x, row);
        agree = agree && corners.pixels[corner] == visibility && on_plane_of(corner, first);
      }
      for (int x = left; x < std::min(left + block_px, view.Width()); ++x) {
        if (at_corner(x, view.Width()) && at_corner(y, view.Height())) continue;
        const std::size_t pixel = view.region.Index(x, y);
        if (agree && on_plane_of(pixel, first)) {
          sun_visibility.pixels[pixel] = visibility;
        } else {
          wanted[static_cast<std::size_t>(x)] = 1;
        }
      }
    }
    cast_row(y, [&](int x) { return wanted[static_cast<std::size_t>(x)] != 0; });
  });
  return sun_visibility;
}

}  // namespace pleinair

#include "relight/internal/surface_gather.h"

#include <algorithm>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/internal/plane_blocks.h"

namespace pleinair {
namespace {

// Of a point in a triangle; one a hair outside counts as on the edge. Patches have an area.
glm::vec3 BarycentricOf(const glm::vec3& point_m,
                        const glm::vec3& a_m,
                        const glm::vec3& b_m,
                        const glm::vec3& c_m) {
  const glm::vec3 normal = glm::cross(b_m - a_m, c_m - a_m);
  const float twice_area_squared = glm::dot(normal, normal);
  glm::vec3 weights(1.0f / 3.0f);
  if (!(twice_area_squared > 0.0f)) return weights;
  weights.x = glm::dot(normal, glm::cross(c_m - b_m, point_m - b_m)) / twice_area_squared;
  weights.y = glm::dot(normal, glm::cross(a_m - c_m, point_m - c_m)) / twice_area_squared;
  weights.z = 1.0f - weights.x - weights.y;
  weights = glm::max(weights, glm::vec3(0.0f));
  return weights / (weights.x + weights.y + weights.z);
}

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
    : rays_(corners.Rays()) {
  entry_begin_.assign(1, 0);
  entry_begin_.reserve(face.pixels.size() + 1);
  for (std::size_t pixel = 0; pixel < face.pixels.size(); ++pixel) {
    if (face.pixels[pixel] != PatchScene::kSky) {
      const auto pixel_face = static_cast<std::size_t>(face.pixels[pixel]);
      const glm::uvec3& vertices = scene.mesh.triangles[pixel_face / 2];
      const glm::vec3 weights = BarycentricOf(view.position_world_m.pixels[pixel],
                                              scene.mesh.positions_m[vertices.x],
                                              scene.mesh.positions_m[vertices.y],
                                              scene.mesh.positions_m[vertices.z]);
      for (int i = 0; i < 3; ++i) {
        entries_.push_back(
            {corners.ReceiversOf(pixel_face)[static_cast<std::size_t>(i)], weights[i]});
      }
    }
    entry_begin_.push_back(static_cast<std::uint32_t>(entries_.size()));
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

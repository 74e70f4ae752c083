#include "relight/transport/view_geometry.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "relight/transport/pixel_blocks.h"
#include "relight/transport/same_plane.h"

namespace pleinair {
namespace {

bool IsOnPlaneOf(std::size_t first, std::size_t other, float range_m, const SurfaceView& view) {
  return view.region.pixels[other] == view.region.pixels[first] &&
         SamePlane(view.position_world_m.pixels[first],
                   view.normal_world.pixels[first],
                   view.position_world_m.pixels[other],
                   view.normal_world.pixels[other],
                   range_m);
}

class GeometryCast {
 public:
  GeometryCast(const PatchScene& scene,
               const ViewRays& rays,
               SurfaceView& view,
               Image<std::int32_t>& side)
      : scene_(scene), rays_(rays), view_(view), side_(side) {
    // Nearer than this an eye may be on the mesh.
    constexpr float kOffMeshM = 0.01f;
    if (scene.caster.DistanceTo(rays.origin_m, kOffMeshM) >= kOffMeshM) {
      where_ = RayCaster::Origin::kOffMesh;
    }
  }

  void CastRow(int y, std::span<const std::uint8_t> wanted) {
    std::vector<glm::vec3> directions;
    std::vector<std::size_t> pixels;
    for (int x = 0; x < rays_.width; ++x) {
      if (wanted[static_cast<std::size_t>(x)] == 0) continue;
      const std::size_t pixel = side_.Index(x, y);
      ShowNothing(pixel);
      const glm::vec3 direction = rays_.Direction(pixel);
      if (direction == glm::vec3(0.0f)) continue;
      directions.push_back(direction);
      pixels.push_back(pixel);
    }
    std::vector<FaceHit> hits(directions.size());
    scene_.caster.IntersectFrom(
        rays_.origin_m, where_, directions.data(), directions.size(), hits.data());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits[i].triangle == FaceHit::kNone) continue;
      const std::int32_t shown = PatchScene::SideOfHit(hits[i]);
      Show(Plane(shown), directions[i], pixels[i]);
    }
  }

  // Between corners on one plane: on that of the nearest.
  bool FillBetween(const PixelBlock& block, const std::array<std::size_t, 4>& corners) {
    if (!IsOnOnePlane(corners)) return false;
    std::array<ShownPlane, 4> planes;
    for (std::size_t k = 0; k < 4; ++k) planes[k] = Plane(side_.pixels[corners[k]]);
    bool is_seen = true;
    block.ForPixelsBetween([&](int x, int y) {
      const std::size_t pixel = side_.Index(x, y);
      const glm::vec3 direction = rays_.Direction(pixel);
      is_seen = is_seen && direction != glm::vec3(0.0f);
      Show(planes[block.NearestCorner(x, y)], direction, pixel);
    });
    return is_seen;
  }

  void ShowNothing(std::size_t pixel) {
    side_.pixels[pixel] = PatchScene::kSky;
    view_.region.pixels[pixel] = SurfaceView::kNoRegion;
    view_.position_world_m.pixels[pixel] = glm::vec3(0.0f);
    view_.normal_world.pixels[pixel] = glm::vec3(0.0f);
  }

 private:
  struct ShownPlane {
    std::int32_t side = 0;
    std::int32_t region = 0;
    glm::vec3 normal{0.0f};          // Of the triangle,
    glm::vec3 surface_normal{0.0f};  // and of what it stands for.
    double height_m = 0.0;           // Along the normal, over the eye.
  };

  ShownPlane Plane(std::int32_t shown) const {
    const std::size_t triangle = static_cast<std::size_t>(shown) / 2;
    const glm::vec3 normal = scene_.SideNormal(static_cast<std::size_t>(shown));
    const glm::dvec3 corner_m(scene_.mesh.positions_m[scene_.mesh.triangles[triangle].x]);
    return {shown,
            static_cast<std::int32_t>(scene_.mesh.triangle_group[triangle]),
            normal,
            scene_.SurfaceNormal(static_cast<std::size_t>(shown)),
            glm::dot(glm::dvec3(normal), corner_m - glm::dvec3(rays_.origin_m))};
  }

  bool IsOnOnePlane(const std::array<std::size_t, 4>& corners) const {
    const std::size_t first = corners[0];
    if (side_.pixels[first] == PatchScene::kSky) return false;
    const float range_m = glm::distance(rays_.origin_m, view_.position_world_m.pixels[first]);
    return std::all_of(corners.begin() + 1, corners.end(), [&](std::size_t corner) {
      return side_.pixels[corner] != PatchScene::kSky && IsOnPlaneOf(first, corner, range_m, view_);
    });
  }

  // On the triangle's plane to rounding, where a ray's distance alone would be off it.
  void Show(const ShownPlane& plane, const glm::vec3& direction, std::size_t pixel) {
    const double distance_m =
        plane.height_m / glm::dot(glm::dvec3(plane.normal), glm::dvec3(direction));
    side_.pixels[pixel] = plane.side;
    view_.region.pixels[pixel] = plane.region;
    view_.position_world_m.pixels[pixel] =
        glm::vec3(glm::dvec3(rays_.origin_m) + distance_m * glm::dvec3(direction));
    // Turned to the eye it has to be.
    const bool is_turned = glm::dot(plane.surface_normal, direction) < 0.0f;
    view_.normal_world.pixels[pixel] = is_turned ? plane.surface_normal : plane.normal;
  }

  const PatchScene& scene_;
  const ViewRays& rays_;
  SurfaceView& view_;
  Image<std::int32_t>& side_;
  RayCaster::Origin where_ = RayCaster::Origin::kMayBeOnMesh;
};

}  // namespace

PlanarBlocks CastGeometry(const PatchScene& scene,
                          const ViewRays& rays,
                          int block_px,
                          SurfaceView& view,
                          Image<std::int32_t>& side,
                          const ChooseBlocks& choose,
                          const PlanarBlocks& before) {
  PlanarBlocks planar{PixelBlocks(rays.width, rays.height, block_px), {}};
  PixelBlocks& blocks = planar.blocks;
  planar.is_planar.assign(blocks.Count(), 0);
  view.region_names = scene.mesh.group_names;
  SizeFor(blocks, view.region);
  SizeFor(blocks, view.position_world_m);
  SizeFor(blocks, view.normal_world);
  SizeFor(blocks, side);
  GeometryCast cast(scene, rays, view, side);
  const auto cast_row = [&](int y, std::span<const std::uint8_t> wanted) {
    cast.CastRow(y, wanted);
  };
  const auto fill_between = [&](int column, int row, const PixelBlock& block) {
    const bool is_filled = cast.FillBetween(block, blocks.Corners(block));
    planar.is_planar[blocks.Index(column, row)] = is_filled ? 1 : 0;
    return is_filled;
  };
  const auto blank = [&](std::size_t pixel) { cast.ShowNothing(pixel); };
  ForCorners(blocks, cast_row, blank);
  if (choose) {
    const PixelBlocks all_corners = blocks;
    blocks.Choose(choose(all_corners), before.blocks);
    ForCornersLeftOut(blocks, blank);
  }
  ForBetweenCorners(blocks, cast_row, fill_between, blank);
  return planar;
}

PlanarBlocks FindPlanarBlocks(const SurfaceView& view, const glm::vec3& eye_m, int block_px) {
  PlanarBlocks planar{PixelBlocks(view.Width(), view.Height(), block_px), {}};
  const PixelBlocks& blocks = planar.blocks;
  planar.is_planar.assign(blocks.Count(), 0);
  if (blocks.SidePx() == 1) return planar;
  tbb::parallel_for(0, blocks.Rows(), [&](int row) {
    for (int column = 0; column < blocks.Columns(); ++column) {
      const PixelBlock block = blocks.At(column, row);
      const std::size_t first = view.region.Index(block.left, block.top);
      if (view.region.pixels[first] == SurfaceView::kNoRegion) continue;
      const float range_m = glm::distance(eye_m, view.position_world_m.pixels[first]);
      bool is_planar = true;
      for (int y = block.top; y <= block.bottom; ++y) {
        for (int x = block.left; x <= block.right && is_planar; ++x) {
          is_planar = IsOnPlaneOf(first, view.region.Index(x, y), range_m, view);
        }
      }
      planar.is_planar[blocks.Index(column, row)] = is_planar ? 1 : 0;
    }
  });
  return planar;
}

}  // namespace pleinair

#include "relight/transport/view_geometry.h"

#include <optional>
#include <span>
#include <vector>

#include <glm/geometric.hpp>

#include "relight/transport/pixel_blocks.h"
#include "relight/transport/same_plane.h"

namespace pleinair {
namespace {

class GeometryCast {
 public:
  GeometryCast(const PatchScene& scene,
               const ViewRays& rays,
               SurfaceView& view,
               Image<std::int32_t>& face)
      : scene_(scene), rays_(rays), view_(view), face_(face) {
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
      const std::optional<glm::vec3> direction = rays_.direction(x, y);
      if (!direction) continue;
      directions.push_back(*direction);
      pixels.push_back(face_.Index(x, y));
    }
    std::vector<FaceHit> hits(directions.size());
    scene_.caster.IntersectFrom(
        rays_.origin_m, where_, directions.data(), directions.size(), hits.data());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits[i].triangle == FaceHit::kNone) continue;
      const std::int32_t shown = PatchScene::FaceOfHit(hits[i]);
      Show(shown, scene_.FaceNormal(static_cast<std::size_t>(shown)), directions[i], pixels[i]);
    }
  }

  bool OnOnePlane(const BlockCorners& corners) const {
    const std::size_t first = corners[0];
    if (face_.pixels[first] == PatchScene::kSky) return false;
    const float range_m = glm::distance(rays_.origin_m, view_.position_world_m.pixels[first]);
    for (const std::size_t corner : std::span(corners).subspan(1)) {
      if (face_.pixels[corner] == PatchScene::kSky ||
          view_.region.pixels[corner] != view_.region.pixels[first] ||
          !SamePlane(view_.position_world_m.pixels[first],
                     view_.normal_world.pixels[first],
                     view_.position_world_m.pixels[corner],
                     view_.normal_world.pixels[corner],
                     range_m)) {
        return false;
      }
    }
    return true;
  }

  // On the plane of the nearest corner.
  bool Fill(int x, int y, const BlockCorners& corners) {
    const std::optional<glm::vec3> direction = rays_.direction(x, y);
    if (!direction) return false;
    const auto width = static_cast<std::size_t>(face_.width);
    const auto column = [&](std::size_t pixel) { return static_cast<int>(pixel % width); };
    const auto row = [&](std::size_t pixel) { return static_cast<int>(pixel / width); };
    const std::size_t right = 2 * x > column(corners[0]) + column(corners[1]) ? 1 : 0;
    const std::size_t lower = 2 * y > row(corners[0]) + row(corners[2]) ? 2 : 0;
    const std::size_t nearest = corners[right + lower];
    Show(face_.pixels[nearest], view_.normal_world.pixels[nearest], *direction, face_.Index(x, y));
    return true;
  }

 private:
  // On the face's plane to rounding, where a ray's distance alone would be off it.
  void Show(std::int32_t shown,
            const glm::vec3& normal,
            const glm::vec3& direction,
            std::size_t pixel) {
    const std::size_t patch = static_cast<std::size_t>(shown) / 2;
    const glm::dvec3 corner_m(scene_.mesh.positions_m[scene_.mesh.triangles[patch].x]);
    const glm::dvec3 origin_m(rays_.origin_m);
    const double distance_m = glm::dot(glm::dvec3(normal), corner_m - origin_m) /
                              glm::dot(glm::dvec3(normal), glm::dvec3(direction));
    face_.pixels[pixel] = shown;
    view_.region.pixels[pixel] = static_cast<std::int32_t>(scene_.mesh.triangle_group[patch]);
    view_.position_world_m.pixels[pixel] = glm::vec3(origin_m + distance_m * glm::dvec3(direction));
    view_.normal_world.pixels[pixel] = normal;
  }

  const PatchScene& scene_;
  const ViewRays& rays_;
  SurfaceView& view_;
  Image<std::int32_t>& face_;
  RayCaster::Origin where_ = RayCaster::Origin::kMayBeOnMesh;
};

}  // namespace

void CastGeometry(const PatchScene& scene,
                  const ViewRays& rays,
                  int block_px,
                  SurfaceView& view,
                  Image<std::int32_t>& face) {
  view.region_names = scene.mesh.group_names;
  Reset(rays.width, rays.height, SurfaceView::kNoRegion, view.region);
  Reset(rays.width, rays.height, glm::vec3(0.0f), view.position_world_m);
  Reset(rays.width, rays.height, glm::vec3(0.0f), view.normal_world);
  Reset(rays.width, rays.height, PatchScene::kSky, face);
  GeometryCast cast(scene, rays, view, face);
  CastInBlocks(
      {rays.width, rays.height, block_px},
      [&](int y, std::span<const std::uint8_t> wanted) { cast.CastRow(y, wanted); },
      [&](const BlockCorners& corners) { return cast.OnOnePlane(corners); },
      [&](int x, int y, const BlockCorners& corners) { return cast.Fill(x, y, corners); });
}

}  // namespace pleinair

#include "objects/surface_point.h"

#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "objects/internal/nearest_point.h"

namespace pleinair {
namespace {

std::array<glm::dvec3, 3> CornersOf(const Mesh& mesh, std::uint32_t triangle) {
  const glm::uvec3& corners = mesh.triangles[triangle];
  return {glm::dvec3(mesh.positions_m[corners.x]),
          glm::dvec3(mesh.positions_m[corners.y]),
          glm::dvec3(mesh.positions_m[corners.z])};
}

// Unit, by winding; none for a triangle without area. In double precision: that of a sliver is as
// good as its corners.
std::optional<glm::dvec3> NormalOf(const std::array<glm::dvec3, 3>& corners) {
  const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double length = glm::length(normal);
  if (!(length > 0.0) || !std::isfinite(length)) return std::nullopt;
  return normal / length;
}

// The surface point for a position near the triangle. `outwards` points to the side that is looked
// at.
std::optional<SurfacePoint> PointOf(const Mesh& mesh,
                                    std::uint32_t triangle,
                                    const glm::dvec3& position_m,
                                    const glm::dvec3& outwards) {
  const auto corners = CornersOf(mesh, triangle);
  const auto normal = NormalOf(corners);
  if (!normal) return std::nullopt;
  SurfacePoint point;
  point.normal = glm::dot(*normal, outwards) < 0.0 ? -*normal : *normal;
  point.position_m = position_m - glm::dot(position_m - corners[0], *normal) * *normal;
  point.triangle = triangle;
  if (triangle < mesh.triangle_group.size() &&
      mesh.triangle_group[triangle] < mesh.group_names.size()) {
    point.group = mesh.group_names[mesh.triangle_group[triangle]];
  }
  return point;
}

}  // namespace

std::optional<SurfacePoint> SurfaceAlong(const RayCaster& caster,
                                         const Mesh& mesh,
                                         const glm::dvec3& origin_m,
                                         const glm::dvec3& direction) {
  const auto hit = caster.Intersect(glm::vec3(origin_m), glm::normalize(glm::vec3(direction)));
  if (!hit) return std::nullopt;
  return PointOf(mesh, hit->triangle, hit->position_m, -direction);
}

std::optional<SurfacePoint> SurfaceAt(const RayCaster& caster,
                                      const Mesh& mesh,
                                      const Camera& camera,
                                      const glm::dvec2& pixel) {
  const auto direction_camera = DirectionFromPixel(camera.intrinsics, pixel);
  if (!direction_camera) return std::nullopt;
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  return SurfaceAlong(
      caster, mesh, camera.CentreWorldM(), glm::normalize(world_from_camera * *direction_camera));
}

std::optional<SurfacePoint> NearestSurface(const Mesh& mesh,
                                           const glm::dvec3& position_m,
                                           const glm::dvec3& eye_m) {
  std::optional<SurfacePoint> nearest;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    auto corners = CornersOf(mesh, triangle);
    for (glm::dvec3& corner : corners) corner -= position_m;
    const glm::dvec3 offset = NearestToOrigin(corners).point;
    const double distance_m = glm::length(offset);
    if (!(distance_m < nearest_m)) continue;
    const glm::dvec3 found = position_m + offset;
    const auto point = PointOf(mesh, triangle, found, eye_m - found);
    if (!point) continue;
    nearest = point;
    nearest_m = distance_m;
  }
  return nearest;
}

}  // namespace pleinair

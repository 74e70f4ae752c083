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

// Just off the surface, on the side that is looked at.
glm::dvec3 Above(const SurfacePoint& point) {
  return glm::dvec3(OffsetFromSurface(glm::vec3(point.position_m), glm::vec3(point.normal)));
}

// A direction along one surface, carried on to the next as if both were folded flat.
glm::dvec3 FoldedOnto(const glm::dvec3& direction,
                      const glm::dvec3& from_normal,
                      const glm::dvec3& to_normal) {
  const glm::dvec3 crease = glm::cross(from_normal, to_normal);
  const double sine = glm::length(crease);
  // From one plane to a parallel one there is no fold.
  if (!(sine > 1e-9)) return direction;
  const glm::dvec3 along = crease / sine;
  const glm::dvec3 across_from = glm::cross(from_normal, along);
  const glm::dvec3 across_to = glm::cross(to_normal, along);
  return glm::normalize(glm::dot(direction, along) * along +
                        glm::dot(direction, across_from) * across_to);
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

std::optional<glm::dvec3> DirectionOnSurface(const SurfacePoint& point,
                                             const Camera& camera,
                                             const glm::dvec2& right_up) {
  const glm::dmat3 camera_from_world(camera.camera_from_world);
  const glm::dvec3 at = glm::dvec3(camera.camera_from_world * glm::dvec4(point.position_m, 1.0));
  const glm::dvec3 normal = camera_from_world * point.normal;
  const double asked = glm::length(right_up);
  if (!(at.z > 0.0) || !(asked > 0.0)) return std::nullopt;
  // The picture of a way along the surface lies in the plane of the sight lines of that direction
  // in the picture; (x, y) / z moves along (right, down).
  const glm::dvec3 in_picture(right_up.x / asked, -right_up.y / asked, 0.0);
  const glm::dvec3 direction = glm::cross(glm::cross(at, in_picture), normal);
  const double length = glm::length(direction);
  // Relative to the sine of the angle to the surface: a millionth of it is edge-on.
  if (!(std::abs(glm::dot(at, normal)) > 1e-6 * glm::length(at)) || !(length > 0.0)) {
    return std::nullopt;
  }
  const glm::dvec3 picture_motion = direction * at.z - at * direction.z;
  const double sign = glm::dot(picture_motion, in_picture) < 0.0 ? -1.0 : 1.0;
  return glm::transpose(camera_from_world) * (sign / length * direction);
}

std::optional<SurfacePoint> StepOnSurface(const RayCaster& caster,
                                          const Mesh& mesh,
                                          const SurfacePoint& from,
                                          const glm::dvec3& direction,
                                          double step_m) {
  constexpr double kDeepestSteps = 10.0;
  // A step that meets more surfaces than this goes round in a crevice smaller than itself.
  constexpr int kMostSurfaces = 8;
  SurfacePoint at = from;
  glm::dvec3 along = direction;
  double left_m = step_m;
  for (int surface = 0; surface < kMostSurfaces; ++surface) {
    const glm::dvec3 above = Above(at);
    const auto ahead = SurfaceAlong(caster, mesh, above, along);
    const double ahead_m = ahead ? glm::distance(ahead->position_m, above) : left_m;
    if (!(ahead_m < left_m)) {
      auto below = SurfaceAlong(caster, mesh, above + left_m * along, -at.normal);
      if (!below || glm::distance(below->position_m, above + left_m * along) >
                        kDeepestSteps * std::abs(step_m)) {
        return std::nullopt;
      }
      return below;
    }
    left_m -= ahead_m;
    along = FoldedOnto(along, at.normal, ahead->normal);
    at = *ahead;
  }
  return std::nullopt;
}

}  // namespace pleinair

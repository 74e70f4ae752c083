#include "ray_cast_reference.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace pleinair::test {

Image<VisiblePoint> CastPicture(const RayCaster& caster, const Camera& camera) {
  const CameraIntrinsics& k = camera.intrinsics;
  Image<VisiblePoint> points(k.width_px, k.height_px);
  const glm::vec3 eye(camera.CentreWorldM());
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  for (int y = 0; y < k.height_px; ++y) {
    for (int x = 0; x < k.width_px; ++x) {
      const glm::dvec3 direction = glm::normalize(
          world_from_camera * glm::dvec3((x - k.cx_px) / k.fx_px, (y - k.cy_px) / k.fy_px, 1.0));
      const auto hit = caster.Intersect(eye, glm::vec3(direction));
      if (!hit) continue;
      VisiblePoint& point = points.At(x, y);
      point.is_hit = true;
      point.hit = *hit;
      point.normal_to_viewer = glm::dot(hit->geometric_normal, glm::vec3(direction)) > 0.0f
                                   ? -hit->geometric_normal
                                   : hit->geometric_normal;
    }
  }
  return points;
}

Gray8Image ReferenceShadowMask(const RayCaster& caster,
                               const Image<VisiblePoint>& points,
                               const glm::dvec3& to_sun) {
  Gray8Image mask(points.width, points.height, 0);
  const glm::vec3 direction(to_sun);
  for (std::size_t i = 0; i < points.pixels.size(); ++i) {
    const VisiblePoint& point = points.pixels[i];
    if (!point.is_hit || glm::dot(glm::dvec3(point.normal_to_viewer), to_sun) <= 0.0) continue;
    const glm::vec3 from = OffsetFromSurface(point.hit.position_m, point.normal_to_viewer);
    if (caster.Occluded(from, direction)) mask.pixels[i] = 255;
  }
  return mask;
}

Gray8Image EdgeNeighbourhood(const Image<VisiblePoint>& points,
                             const Gray8Image& mask,
                             const Camera& camera) {
  Gray8Image edges(points.width, points.height, 0);
  for (int y = 0; y < points.height; ++y) {
    for (int x = 0; x < points.width; ++x) {
      const VisiblePoint& here = points.At(x, y);
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, points.height - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, points.width - 1); ++u) {
          const VisiblePoint& there = points.At(u, v);
          bool is_edge = mask.At(u, v) != mask.At(x, y) || here.is_hit != there.is_hit;
          if (here.is_hit && there.is_hit && here.hit.triangle != there.hit.triangle) {
            const float footprint =
                here.hit.distance_m / static_cast<float>(camera.intrinsics.fx_px);
            const glm::vec3 step = there.hit.position_m - here.hit.position_m;
            is_edge = is_edge || std::abs(glm::dot(step, here.normal_to_viewer)) > footprint;
          }
          if (is_edge) edges.At(x, y) = 1;
        }
      }
    }
  }
  return edges;
}

MaskComparison CompareShadowMasks(ShadowMask& shadow_mask,
                                  const Mesh& everything,
                                  const Camera& camera,
                                  const glm::dvec3& to_sun) {
  const RayCaster caster(everything);
  const Image<VisiblePoint> points = CastPicture(caster, camera);
  const Gray8Image reference = ReferenceShadowMask(caster, points, to_sun);
  const Gray8Image edges = EdgeNeighbourhood(points, reference, camera);
  const Gray8Image drawn = shadow_mask.Draw(camera, to_sun);
  MaskComparison comparison;
  comparison.pixels = reference.pixels.size();
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    const VisiblePoint& point = points.pixels[i];
    if (reference.pixels[i] != 0) {
      ++comparison.shadowed;
    } else if (point.is_hit && glm::dot(glm::dvec3(point.normal_to_viewer), to_sun) > 0.0) {
      ++comparison.lit;
    }
    // Edge-on to the sun within the rounding of a float normal: lit or facing away is open.
    constexpr double kEdgeOn = 1e-6;
    if (point.is_hit && std::abs(glm::dot(glm::dvec3(point.normal_to_viewer), to_sun)) < kEdgeOn) {
      continue;
    }
    if (edges.pixels[i] == 0 && drawn.pixels[i] != reference.pixels[i]) {
      ++comparison.different_off_edges;
    }
  }
  return comparison;
}

}  // namespace pleinair::test

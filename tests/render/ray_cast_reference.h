// What the renderer should show, by ray casting: slow, simple, and sharing no code with it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"
#include "shadow_mask.h"

namespace pleinair::test {

// Per pixel of an undistorted camera: what a ray through its centre meets.
struct VisiblePoint {
  bool is_hit = false;
  RayHit hit;
  glm::vec3 normal_to_viewer{0.0f};
};

Image<VisiblePoint> CastPicture(const RayCaster& caster, const Camera& camera);

// 255 where the visible side faces the sun and something stands between.
Gray8Image ReferenceShadowMask(const RayCaster& caster,
                               const Image<VisiblePoint>& points,
                               const glm::dvec3& to_sun);

// 1 within one pixel of an edge: of the mask, of the mesh against emptiness, of a surface against
// one that is not in its tangent plane.
Gray8Image EdgeNeighbourhood(const Image<VisiblePoint>& points,
                             const Gray8Image& mask,
                             const Camera& camera);

struct MaskComparison {
  std::size_t pixels = 0;
  std::size_t shadowed = 0;             // By the reference.
  std::size_t lit = 0;                  // Hit, facing the sun, unshadowed.
  std::size_t different_off_edges = 0;  // Farther than a pixel from every edge.
  double DifferentShare() const {
    return static_cast<double>(different_off_edges) / static_cast<double>(pixels);
  }
};

MaskComparison CompareShadowMasks(ShadowMask& shadow_mask,
                                  const Mesh& everything,
                                  const Camera& camera,
                                  const glm::dvec3& to_sun);

}  // namespace pleinair::test

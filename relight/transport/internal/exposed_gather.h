// Rays from those parts of faces that light can reach.
#pragma once

#include <cstdint>
#include <vector>

#include "relight/transport/face_points.h"
#include "relight/transport/transport.h"

namespace pleinair::internal {

// What the rays of each face point meet, `rays_per_point` a point: a face, kSky or kDark.
struct ExposedRays {
  static constexpr std::int32_t kSky = -1;
  static constexpr std::int32_t kDark = -2;

  FacePoints points;
  int rays_per_point = 0;
  std::vector<std::int32_t> source;      // Per point and ray.
  std::vector<glm::vec3> sky_direction;  // Of the rays that meet kSky, in their order.
  std::vector<std::uint64_t> sky_begin;  // Per point, and one more.
};

// Light comes from the sky alone, so that it reaches exactly what the sky sees by way of any number
// of surfaces. The search starts at points from which a ray escapes to the sky; each point's rays
// then find further ones where they meet a cell that has none. A point is the very place that a ray
// met, stepped back along it: it certainly lies in the open.
//
// A cell of a face is found when a ray happens to meet it: one that is seen through a small gap
// alone may be missed, and then counts as not exposed.
ExposedRays GatherFromExposedFaces(const PatchScene& scene, const GatherOptions& options);

}  // namespace pleinair::internal

// An object as a surface point sees it, from its bounds alone: how much of the view it can fill,
// and the rays that may meet it.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "scene/low_discrepancy.h"
#include "scene/mesh.h"

namespace pleinair {

struct ObjectBounds {
  glm::vec3 centre_m{0.0f};
  float radius_m = 0.0f;
  BoundingBox box;
};

// Bounds of each group's triangles; none for a group without any.
std::vector<std::optional<ObjectBounds>> BoundsOfObjects(const Mesh& mesh);

inline float DistanceTo(const BoundingBox& box, const glm::vec3& position_m) {
  return glm::distance(position_m, glm::clamp(position_m, box.lower_m, box.upper_m));
}

// Whether a ray may meet the box: no where it passes beside it by more than rounding.
inline bool MayMeet(const BoundingBox& box, const glm::vec3& start_m, const glm::vec3& direction) {
  // The slabs' entry and exit; a direction along a slab gives infinities, or NaN on its border,
  // which min and max drop as their second argument.
  float entry = 0.0f;
  float exit = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const float inverse = 1.0f / direction[axis];
    const float a = (box.lower_m[axis] - start_m[axis]) * inverse;
    const float b = (box.upper_m[axis] - start_m[axis]) * inverse;
    entry = std::max(entry, std::min(a, b));
    exit = std::min(exit, std::max(a, b));
  }
  // Three roundings an axis.
  return !(entry > exit * (1.0f + 1e-6f) + 1e-6f);
}

// The directions in which an object's bounding sphere is seen.
struct ObjectCone {
  glm::vec3 axis{0.0f};
  // 1 - cos of the half angle: solid angle / 2 pi. 2 from inside.
  float one_minus_cos = 2.0f;

  ObjectCone(const ObjectBounds& object, const glm::vec3& from_m);
  // Bound of the share of a cosine-weighted hemisphere that the cone fills.
  float LargestShare(const glm::vec3& normal) const;
};

// Low-discrepancy directions over a cone, with the share of the cosine-weighted hemisphere that
// each stands for. The same set at every point, standing on its plane or turned with its cone, so
// that what the set misses changes smoothly over a surface and does not show as noise.
class ConeDirections {
 public:
  explicit ConeDirections(int count);

  template <class Visit>  // visit(direction, share)
  void ForEach(const ObjectCone& cone, const glm::vec3& normal, const Visit& visit) const {
    const NormalFrame hemisphere(normal);
    const float each = 1.0f / static_cast<float>(points_.size());
    // From a half angle of 60 deg on, a cosine-distributed ray stands nowhere for more than one
    // that is uniform over the cone: the hemisphere's own set is the better one.
    if (cone.one_minus_cos > 0.5f) {
      for (const Point& point : points_) {
        visit(point.x * hemisphere.tangent + point.y * hemisphere.bitangent + point.z * normal,
              each);
      }
      return;
    }
    glm::vec3 across = glm::cross(normal, cone.axis);
    const float length = glm::length(across);
    // Straight above there is no such direction; a ring around the axis is then any direction's.
    across = length > 1e-4f ? across / length : hemisphere.tangent;
    const glm::vec3 upwards = glm::normalize(glm::cross(cone.axis, across));
    for (const Point& point : points_) {
      const float down = point.height * cone.one_minus_cos;
      const float scale = std::sqrt(cone.one_minus_cos * (2.0f - down));
      const glm::vec3 direction =
          scale * (point.x * across + point.y * upwards) + (1.0f - down) * cone.axis;
      const float cosine = glm::dot(normal, direction);
      if (cosine > 0.0f) visit(direction, 2.0f * cone.one_minus_cos * cosine * each);
    }
  }

 private:
  struct Point {
    float height;  // In (0, 1).
    float x;       // On the unit disc, the root of height from its middle.
    float y;
    float z;  // On the hemisphere above it.
  };
  std::vector<Point> points_;
};

}  // namespace pleinair

// Where a moving convex body meets a triangle.
#pragma once

#include <array>
#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "objects/internal/support_tree.h"

namespace pleinair {

// The convex hull of points, moved by an affine transform.
struct ConvexBody {
  const SupportTree& points;
  glm::dmat3 linear{1.0};
  glm::dvec3 offset{0.0};

  glm::dvec3 Furthest(const glm::dvec3& direction) const {
    return linear * points.Furthest(direction * linear) + offset;
  }
};

struct Interval {
  double from = 0.0;
  double to = 0.0;
};

// The ways along `direction` (unit) within `limit` either way at which the body meets the triangle:
// one interval, as both are convex.
//
// Source    Van den Bergen, Ray casting against general convex objects with application to
//           continuous collision detection, 2004: GJK, with the body moved up to each separating
//           plane that it finds.
// Accuracy  The ends lie on the true interval or outside it: 1e-8 of the distance between the body
//           and the triangle's furthest corner, unless the way grazes the triangle.
std::optional<Interval> MeetingOf(const ConvexBody& body,
                                  const std::array<glm::dvec3, 3>& triangle,
                                  const glm::dvec3& direction,
                                  double limit);

// Whether they meet where the body is.
bool Meet(const ConvexBody& body, const std::array<glm::dvec3, 3>& triangle);

}  // namespace pleinair

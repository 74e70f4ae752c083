#include "objects/internal/convex_cast.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include <glm/geometric.hpp>

#include "objects/internal/nearest_point.h"

namespace pleinair {
namespace {

// Share of the distances that occur, whose rounding errors are some 1e-14 of them: a micrometre
// where the triangle is 100 m large.
constexpr double kTouching = 1e-8;
// Bodies with thousands of corners take some 20. More means that rounding errors repeat; the way
// found so far then still ends short of the triangle.
constexpr int kMostRounds = 60;

glm::dvec3 FurthestOf(const std::array<glm::dvec3, 3>& triangle, const glm::dvec3& direction) {
  const double at_0 = glm::dot(triangle[0], direction);
  const double at_1 = glm::dot(triangle[1], direction);
  const double at_2 = glm::dot(triangle[2], direction);
  if (at_0 >= at_1 && at_0 >= at_2) return triangle[0];
  return at_1 >= at_2 ? triangle[1] : triangle[2];
}

// How far the body, moved by `start`, can go on along `direction` before it meets the triangle;
// none where that is further than `length`.
std::optional<double> WayToMeeting(const ConvexBody& body,
                                   const std::array<glm::dvec3, 3>& triangle,
                                   const glm::dvec3& start,
                                   const glm::dvec3& direction,
                                   double length) {
  // The body moved by x meets the triangle where x lies in the set of all differences between a
  // point of the triangle and one of the body.
  const auto furthest_difference = [&](const glm::dvec3& towards) {
    return FurthestOf(triangle, towards) - body.Furthest(-towards);
  };
  double way = 0.0;
  glm::dvec3 at = start;
  std::array<glm::dvec3, 4> corners{furthest_difference(direction)};
  std::size_t corner_count = 1;
  glm::dvec3 to_at = at - corners[0];
  const double tolerance = kTouching * std::max(glm::length(to_at), length);
  for (int round = 0; round < kMostRounds && glm::length(to_at) > tolerance; ++round) {
    const glm::dvec3 corner = furthest_difference(to_at);
    const double apart = glm::dot(to_at, at - corner);
    if (apart > 0.0) {
      const double approach = glm::dot(to_at, direction);
      if (approach >= 0.0) return std::nullopt;
      way -= apart / approach;
      if (way > length) return std::nullopt;
      at = start + way * direction;
    }
    const auto end = corners.begin() + static_cast<std::ptrdiff_t>(corner_count);
    const bool is_new = std::find(corners.begin(), end, corner) == end;
    // The nearest point of the known corners is that of all, and no plane separates it.
    if (!is_new && !(apart > 0.0)) break;
    if (is_new) corners[corner_count++] = corner;
    std::array<glm::dvec3, 4> from_at;
    for (std::size_t i = 0; i < corner_count; ++i) from_at[i] = at - corners[i];
    const NearestOfSimplex nearest = NearestToOrigin(std::span(from_at.data(), corner_count));
    to_at = nearest.point;
    if (nearest.corners == 15u) break;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < corner_count; ++i) {
      if ((nearest.corners >> i & 1u) != 0u) corners[kept++] = corners[i];
    }
    corner_count = kept;
  }
  return way;
}

}  // namespace

std::optional<Interval> MeetingOf(const ConvexBody& body,
                                  const std::array<glm::dvec3, 3>& triangle,
                                  const glm::dvec3& direction,
                                  double limit) {
  const auto forth = WayToMeeting(body, triangle, -limit * direction, direction, 2.0 * limit);
  if (!forth) return std::nullopt;
  const auto back = WayToMeeting(body, triangle, limit * direction, -direction, 2.0 * limit);
  if (!back) return std::nullopt;
  // Rounding errors may swap the ends of an interval of no length.
  const auto [from, to] = std::minmax({*forth - limit, limit - *back});
  return Interval{from, to};
}

bool Meet(const ConvexBody& body, const std::array<glm::dvec3, 3>& triangle) {
  return WayToMeeting(body, triangle, glm::dvec3(0.0), glm::dvec3(0.0), 0.0).has_value();
}

}  // namespace pleinair

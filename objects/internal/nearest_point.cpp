#include "objects/internal/nearest_point.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

using Corners = std::span<const glm::dvec3>;

unsigned Bit(std::size_t corner) { return 1u << corner; }

void KeepNearer(NearestOfSimplex& nearest, const NearestOfSimplex& other) {
  if (glm::dot(other.point, other.point) < glm::dot(nearest.point, nearest.point)) nearest = other;
}

NearestOfSimplex OfSegment(Corners at, std::size_t i, std::size_t j) {
  const glm::dvec3 along = at[j] - at[i];
  const double length2 = glm::dot(along, along);
  const double share = length2 > 0.0 ? -glm::dot(at[i], along) / length2 : 0.0;
  if (!(share > 0.0)) return {at[i], Bit(i)};
  if (!(share < 1.0)) return {at[j], Bit(j)};
  return {at[i] + share * along, Bit(i) | Bit(j)};
}

NearestOfSimplex OfTriangle(Corners at, std::size_t i, std::size_t j, std::size_t k) {
  const glm::dvec3 normal = glm::cross(at[j] - at[i], at[k] - at[i]);
  const double length2 = glm::dot(normal, normal);
  if (length2 > 0.0 && glm::dot(glm::cross(at[i], at[j]), normal) > 0.0 &&
      glm::dot(glm::cross(at[j], at[k]), normal) > 0.0 &&
      glm::dot(glm::cross(at[k], at[i]), normal) > 0.0) {
    return {glm::dot(at[i], normal) / length2 * normal, Bit(i) | Bit(j) | Bit(k)};
  }
  NearestOfSimplex nearest = OfSegment(at, i, j);
  KeepNearer(nearest, OfSegment(at, j, k));
  KeepNearer(nearest, OfSegment(at, k, i));
  return nearest;
}

NearestOfSimplex OfTetrahedron(Corners at) {
  constexpr std::array<std::array<std::size_t, 4>, 4> kFacesAndOpposite = {
      {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}}};
  bool inside = true;
  NearestOfSimplex nearest{at[0], Bit(0)};
  for (const auto& [i, j, k, opposite] : kFacesAndOpposite) {
    const glm::dvec3 normal = glm::cross(at[j] - at[i], at[k] - at[i]);
    const double origin_side = -glm::dot(at[i], normal);
    const double inner_side = glm::dot(at[opposite] - at[i], normal);
    if (origin_side * inner_side > 0.0) continue;
    inside = false;
    KeepNearer(nearest, OfTriangle(at, i, j, k));
  }
  if (inside) return {glm::dvec3(0.0), 15u};
  return nearest;
}

}  // namespace

NearestOfSimplex NearestToOrigin(std::span<const glm::dvec3> corners) {
  switch (corners.size()) {
    case 1:
      return {corners[0], Bit(0)};
    case 2:
      return OfSegment(corners, 0, 1);
    case 3:
      return OfTriangle(corners, 0, 1, 2);
    default:
      return OfTetrahedron(corners);
  }
}

}  // namespace pleinair

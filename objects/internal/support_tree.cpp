#include "objects/internal/support_tree.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

constexpr std::uint32_t kLeafPoints = 8;

}  // namespace

SupportTree::SupportTree(std::vector<glm::dvec3> points) : points_(std::move(points)) {
  Build(0, static_cast<std::uint32_t>(points_.size()));
}

void SupportTree::Build(std::uint32_t first, std::uint32_t count) {
  const auto begin = points_.begin() + first;
  glm::dvec3 lower = *begin;
  glm::dvec3 upper = *begin;
  for (auto point = begin; point != begin + count; ++point) {
    lower = glm::min(lower, *point);
    upper = glm::max(upper, *point);
  }
  const std::size_t node = nodes_.size();
  nodes_.push_back({0.5 * (lower + upper), 0.5 * (upper - lower), first, count});
  if (count <= kLeafPoints) return;
  const glm::dvec3 size = upper - lower;
  int axis = size.y > size.x ? 1 : 0;
  if (size.z > size[axis]) axis = 2;
  const std::uint32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [&](const auto& a, const auto& b) {
    return a[axis] < b[axis];
  });
  nodes_[node].count = 0;
  Build(first, half);
  nodes_[node].first = static_cast<std::uint32_t>(nodes_.size());
  Build(first + half, count - half);
}

const glm::dvec3& SupportTree::Furthest(const glm::dvec3& direction) const {
  const glm::dvec3 absolute = glm::abs(direction);
  const auto bound = [&](std::uint32_t node) {
    return glm::dot(nodes_[node].centre, direction) + glm::dot(nodes_[node].half_size, absolute);
  };
  struct Open {
    std::uint32_t node;
    double bound;
  };
  // Halves that wait: one a level, and 2^32 points have no more levels than that.
  std::array<Open, 40> open{};
  std::size_t open_count = 1;
  open[0] = {0, bound(0)};
  double furthest = -std::numeric_limits<double>::infinity();
  const glm::dvec3* found = points_.data();
  while (open_count > 0) {
    const Open at = open[--open_count];
    if (at.bound <= furthest) continue;
    const Node& node = nodes_[at.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const double distance = glm::dot(points_[i], direction);
        if (!(distance > furthest)) continue;
        furthest = distance;
        found = &points_[i];
      }
      continue;
    }
    Open near{at.node + 1, bound(at.node + 1)};
    Open far{node.first, bound(node.first)};
    if (near.bound < far.bound) std::swap(near, far);
    open[open_count++] = far;
    open[open_count++] = near;
  }
  return *found;
}

}  // namespace pleinair

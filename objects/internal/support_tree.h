// Finds the furthest of some points in a direction: all that convex casts need of an object.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace pleinair {

class SupportTree {
 public:
  // At least one point, all finite.
  explicit SupportTree(std::vector<glm::dvec3> points);

  // The point furthest in `direction`, of any length.
  const glm::dvec3& Furthest(const glm::dvec3& direction) const;

 private:
  struct Node {
    glm::dvec3 centre{0.0};
    glm::dvec3 half_size{0.0};
    std::uint32_t first = 0;  // Of points, in a leaf; else the second child: the first follows.
    std::uint32_t count = 0;  // 0: not a leaf.
  };
  void Build(std::uint32_t first, std::uint32_t count);

  std::vector<glm::dvec3> points_;
  std::vector<Node> nodes_;
};

}  // namespace pleinair

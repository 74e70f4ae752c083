#include "objects/posed_objects.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace pleinair {

double BoxesMoved(const glm::dmat4& from, const glm::dmat4& to, const BoundingBox& box) {
  const glm::dmat4 back = from * glm::inverse(to);
  double farthest_m = 0.0;
  for (const glm::vec3& corner_m : CornersOf(box)) {
    const glm::dvec4 corner(glm::dvec3(corner_m), 1.0);
    farthest_m = std::max(farthest_m, glm::length(glm::dvec3(back * corner - corner)));
  }
  return farthest_m / glm::distance(box.lower_m, box.upper_m);
}

PosedObjects::PosedObjects(std::vector<VirtualObject> objects)
    : given_(std::move(objects)),
      posed_(given_),
      world_from_given_(given_.size(), glm::dmat4(1.0)) {}

bool PosedObjects::Pose(std::span<const glm::dmat4> world_from_given) {
  std::vector<glm::dmat4> poses(world_from_given.begin(), world_from_given.end());
  if (poses.empty()) poses.assign(given_.size(), glm::dmat4(1.0));
  if (poses.size() != given_.size()) {
    throw std::invalid_argument("object poses: " + std::to_string(poses.size()) + " for " +
                                std::to_string(given_.size()) +
                                " objects: expected one each, or none");
  }
  if (poses == world_from_given_) return false;
  std::vector<VirtualObject> posed = posed_;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i] == world_from_given_[i]) continue;
    try {
      posed[i].mesh =
          poses[i] == glm::dmat4(1.0) ? given_[i].mesh : TransformMesh(poses[i], given_[i].mesh);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("object " + std::to_string(i) + ": " + error.what());
    }
  }
  posed_ = std::move(posed);
  world_from_given_ = std::move(poses);
  poses_id_ = StateId::Next();
  return true;
}

}  // namespace pleinair

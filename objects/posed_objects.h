// Virtual objects that move: where each of them is in a frame.
#pragma once

#include <span>
#include <vector>

#include <glm/mat4x4.hpp>

#include "objects/virtual_object.h"
#include "scene/state_id.h"

namespace pleinair {

// How far an object has gone between two poses: the farthest corner of its box, over the box's
// diagonal. `box` is that of the second pose.
double BoxesMoved(const glm::dmat4& from, const glm::dmat4& to, const BoundingBox& box);

class PosedObjects {
 public:
  PosedObjects() = default;
  // Objects in the poses that they have until the first Pose.
  explicit PosedObjects(std::vector<VirtualObject> objects);

  // Takes each object from where it was given, not from where it is, to `world_from_given`, an
  // affine transform an object; empty: all are where they were given. Returns whether anything has
  // moved. The unit matrix gives an object back bit for bit.
  // Throws  std::invalid_argument for another number of poses than of objects, naming it, and as
  //         TransformMesh for impossible ones, naming the object; then all stay where they were.
  bool Pose(std::span<const glm::dmat4> world_from_given);

  // A new identity after each Pose that has moved something.
  StateId PosesId() const { return poses_id_; }

  // From where each was given to where it is.
  const std::vector<glm::dmat4>& Poses() const { return world_from_given_; }
  // In world coordinates.
  const std::vector<VirtualObject>& Objects() const { return posed_; }

 private:
  std::vector<VirtualObject> given_;
  std::vector<VirtualObject> posed_;
  std::vector<glm::dmat4> world_from_given_;
  StateId poses_id_ = StateId::Next();
};

}  // namespace pleinair

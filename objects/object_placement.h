// Objects put onto surfaces, turned, lifted and scaled: functions of poses, without state.
//
// An object stands on its foot: the centre of its bounding box's lower side, in its own
// coordinates, whose +Z is its axis.
#pragma once

#include <memory>
#include <optional>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "objects/surface_point.h"
#include "scene/mesh.h"

namespace pleinair {

// What placing needs of an object's mesh. Immutable; cheap to copy; safe from any thread.
class PlaceableObject {
 public:
  // `mesh` in its own coordinates; open, non-manifold and degenerate ones as well. Throws
  // std::invalid_argument for a mesh without triangles.
  explicit PlaceableObject(const Mesh& mesh);

  const glm::dvec3& FootObject() const { return foot_; }

 private:
  friend class Placing;
  std::shared_ptr<const class SupportTree> corners_;
  glm::dvec3 foot_{0.0};
  double height_ = 0.0;  // From the foot to the upper side of the bounding box.
};

struct RestingObject {
  glm::dmat4 world_from_object{1.0};
  // From where its foot would stand at the point itself. It is slid along the surface to get clear
  // of what stands beside it, and moved along the normal: up onto a step, or down where the point's
  // surface ends.
  glm::dvec3 slid_m{0.0};
  double raised_m = 0.0;
};

// The object moved from any pose to rest on `point`: its axis along the point's normal, its foot at
// the point, then moved to its first contact with the mesh. Its turn about the axis is kept: the
// smallest rotation brings the axis there, from the opposite direction about the object's X axis.
//
// What counts as the object is its convex hull: nothing comes to lie under an arch.
//
// Contact   0.1 mm off the first surface that it meets, nowhere in the mesh, whose triangles count
//           from both sides. An object that meets more than what it stands on is raised onto that
//           (a step, a kerb), or slid along the surface until it is clear of it (a wall). The
//           shorter way is taken. It is slid towards the side of the obstacle on which the point
//           lies.
// Pose      An affine `world_from_object`; its scale stays.
// Returns   None where there is no room: neither way is shorter than the object is large, or the
//           place is not in sight of the point.
// Cost      0.1 ms in the open and 0.8 ms in a corner for 15 000 faces on 1000 triangles
//           (bench/placement_bench.cpp); a pass over all triangles of the mesh.
// Throws    std::invalid_argument for a pose that is not finite or flattens the object.
std::optional<RestingObject> RestOn(const PlaceableObject& object,
                                    const glm::dmat4& world_from_object,
                                    const SurfacePoint& point,
                                    const RayCaster& caster,
                                    const Mesh& mesh);

// The object's axis in the world, unit, and its foot.
glm::dvec3 AxisOf(const glm::dmat4& world_from_object);
glm::dvec3 FootOf(const PlaceableObject& object, const glm::dmat4& world_from_object);

// About its axis through its foot, counter-clockwise seen from above.
glm::dmat4 Turned(const PlaceableObject& object,
                  const glm::dmat4& world_from_object,
                  double angle_rad);

// Along its axis.
glm::dmat4 Lifted(const glm::dmat4& world_from_object, double height_m);

// About its foot, which stays. Throws std::invalid_argument unless `factor` is positive and finite.
glm::dmat4 Scaled(const PlaceableObject& object,
                  const glm::dmat4& world_from_object,
                  double factor);

}  // namespace pleinair

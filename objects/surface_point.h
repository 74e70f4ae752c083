// Points of real surfaces, as a pointer in the picture or a key press picks them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"

namespace pleinair {

struct SurfacePoint {
  glm::dvec3 position_m{0.0};  // In the world, on the triangle's plane.
  glm::dvec3 normal{0.0};      // Unit, of the triangle, turned to the side that is looked at.
  std::uint32_t triangle = 0;  // Of the mesh.
  std::string group;           // The name of the triangle's group; empty where it has none.
};

// In all of these `caster` is made of `mesh`, which is in world coordinates.

// The surface that a place of the picture shows, lens distortion included; the place may lie
// outside the picture. None for the sky, and where the lens has no direction for that place.
//
// Throws  std::invalid_argument as Lens.
std::optional<SurfacePoint> SurfaceAt(const RayCaster& caster,
                                      const Mesh& mesh,
                                      const Camera& camera,
                                      const glm::dvec2& pixel);

// The first surface of a ray; `direction` is unit.
std::optional<SurfacePoint> SurfaceAlong(const RayCaster& caster,
                                         const Mesh& mesh,
                                         const glm::dvec3& origin_m,
                                         const glm::dvec3& direction);

// The point of the mesh that is nearest to `position_m`, its normal turned to `eye_m`. Triangles
// without area do not count. None where there are no others. Cost: all triangles.
std::optional<SurfacePoint> NearestSurface(const Mesh& mesh,
                                           const glm::dvec3& position_m,
                                           const glm::dvec3& eye_m);

// The direction along the surface at `point` that is seen as one to the right (1, 0) of the
// picture, upwards (0, 1) or in between; unit. Without regard to lens distortion, which would turn
// it by less than a key press needs. None where the surface is seen edge-on or lies behind the
// camera.
std::optional<glm::dvec3> DirectionOnSurface(const SurfacePoint& point,
                                             const Camera& camera,
                                             const glm::dvec2& right_up);

// The point of the surface at `step_m` from `from` in a direction along it, `direction` unit and at
// right angles to the normal. Where another surface stands in the way, the way goes on along that
// one. Beyond an edge it goes on along the surface below, at right angles to this one and at most
// ten steps deeper. None where nothing does.
std::optional<SurfacePoint> StepOnSurface(const RayCaster& caster,
                                          const Mesh& mesh,
                                          const SurfacePoint& from,
                                          const glm::dvec3& direction,
                                          double step_m);

}  // namespace pleinair

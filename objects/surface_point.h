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
  std::uint32_t triangle = 0;  // Index of the mesh's triangle.
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

}  // namespace pleinair

// The distance from a point to the triangles of an Embree scene.
#pragma once

#include <embree3/rtcore.h>
#include <glm/ext/vector_uint3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace pleinair {

// To the nearest point of a triangle, or `within_m` where that is less. `vertices` and `triangles`
// are those of the scene's only geometry.
float NearestDistanceM(RTCScene scene,
                       const glm::vec4* vertices,
                       const glm::uvec3* triangles,
                       const glm::vec3& point_m,
                       float within_m);

}  // namespace pleinair

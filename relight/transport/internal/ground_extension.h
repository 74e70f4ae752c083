// Finds the ground of a site and carries it on to the horizon.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "scene/mesh.h"

namespace pleinair {

inline constexpr const char* kGroundExtensionGroup = "ground_extension";

// The level that a site stands on.
struct Ground {
  float height_m = 0.0f;
  std::uint32_t material = 0;         // The one with the largest share of its area.
  std::vector<glm::dvec2> outline_m;  // Convex hull seen from above, counter-clockwise.
};

// The lowest level among the near-horizontal triangles that has at least a quarter of the largest
// level's area; none for a mesh without such triangles.
std::optional<Ground> FindGround(const Mesh& mesh);

// Whether the outline passes nearer to `focus_m` than `horizon_m`, or leaves it outside.
bool EndsNear(const Ground& ground, const glm::dvec2& focus_m, double horizon_m);

// Adds a ring of quads from the ground's outline out to `radius_m` from the outline's middle, as
// group kGroundExtensionGroup. Inside its outline the ground is left as it is. Returns the number
// of triangles added (at the end of the mesh).
std::size_t AddGroundRing(const Ground& ground, double radius_m, Mesh& mesh);

// Lays a square of this albedo under a mesh that is not empty, out to `radius_m` from its middle,
// as group kGroundExtensionGroup: 2 triangles at the end of the mesh. Returns its height, slightly
// below the mesh's foot, so that it covers nothing of the mesh.
float LayGround(double radius_m, const glm::vec3& albedo, Mesh& mesh);

}  // namespace pleinair

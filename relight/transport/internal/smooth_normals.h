// Normals of surfaces that come in many small, noisy triangles.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"

namespace pleinair::internal {

// Per triangle a unit normal of its front: its own or, where `is_small`, the mean over triangles
// around it that look about the same way. So the scatter of a mesh from photographs fades and edges
// stay (Zheng, Fu, Au and Tai, "Bilateral normal filtering for mesh denoising", 2011). Zero for a
// triangle without area. Corners are the same where their positions are.
// Shape  is_small: one a triangle.
std::vector<glm::vec3> SmoothNormals(const Mesh& mesh, const std::vector<std::uint8_t>& is_small);

}  // namespace pleinair::internal

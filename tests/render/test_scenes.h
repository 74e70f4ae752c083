// Small scenes made by hand for the render tests.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/mesh.h"

namespace pleinair::test {

// One material, group "mesh"; normals are the mean of the neighbouring faces'.
Mesh MeshOf(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles, Material material);

Mesh Box(const glm::vec3& lower, const glm::vec3& upper, Material material = {});
// Closed; vertices on the sphere, normals exact.
Mesh Sphere(const glm::vec3& centre, float radius, int rings, Material material = {});
// Two triangles at height z, facing up.
Mesh Ground(float half_size, float z = 0.0f, Material material = {});
// Both in one mesh; materials and groups of both are kept.
Mesh Join(const Mesh& a, const Mesh& b);
// Every triangle turned over.
Mesh TurnedInsideOut(Mesh mesh);

// Looks from `eye` at `target`, world up is +Z.
Camera LookAt(
    const glm::dvec3& eye, const glm::dvec3& target, int width_px, int height_px, double focal_px);

glm::dvec3 DirectionOf(double azimuth_deg, double elevation_deg);

// The recordings and reference data, where they are there.
std::optional<std::filesystem::path> SharedFile(const std::filesystem::path& relative);

}  // namespace pleinair::test

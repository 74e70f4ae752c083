#include "test_scenes.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace pleinair::test {

Mesh MeshOf(std::vector<glm::vec3> positions,
            std::vector<glm::uvec3> triangles,
            Material material) {
  Mesh mesh;
  mesh.positions_m = std::move(positions);
  mesh.triangles = std::move(triangles);
  mesh.materials = {std::move(material)};
  mesh.group_names = {"mesh"};
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.triangle_group.assign(mesh.triangles.size(), 0);
  mesh.normals.assign(mesh.positions_m.size(), glm::vec3(0.0f));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 area = glm::cross(mesh.positions_m[t.y] - mesh.positions_m[t.x],
                                      mesh.positions_m[t.z] - mesh.positions_m[t.x]);
    for (int corner = 0; corner < 3; ++corner) mesh.normals[t[corner]] += area;
  }
  for (glm::vec3& normal : mesh.normals) {
    const float length = glm::length(normal);
    normal = length > 0.0f ? normal / length : glm::vec3(0.0f, 0.0f, 1.0f);
  }
  return mesh;
}

Mesh Box(const glm::vec3& lower, const glm::vec3& upper, Material material) {
  // Four vertices a face, so that normals are the faces' own.
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      const auto first = static_cast<std::uint32_t>(positions.size());
      for (int corner = 0; corner < 4; ++corner) {
        const bool far_u = corner == 1 || corner == 2;
        const bool far_v = corner >= 2;
        glm::vec3 position;
        position[axis] = side == 1 ? upper[axis] : lower[axis];
        position[u] = far_u ? upper[u] : lower[u];
        position[v] = far_v ? upper[v] : lower[v];
        positions.push_back(position);
      }
      if (side == 1) {
        triangles.emplace_back(first, first + 1, first + 2);
        triangles.emplace_back(first, first + 2, first + 3);
      } else {
        triangles.emplace_back(first, first + 2, first + 1);
        triangles.emplace_back(first, first + 3, first + 2);
      }
    }
  }
  return MeshOf(std::move(positions), std::move(triangles), std::move(material));
}

Mesh Sphere(const glm::vec3& centre, float radius, int rings, Material material) {
  const int segments = 2 * rings;
  std::vector<glm::vec3> normals{{0.0f, 0.0f, 1.0f}};
  for (int ring = 1; ring < rings; ++ring) {
    const double polar = std::numbers::pi * ring / rings;
    for (int segment = 0; segment < segments; ++segment) {
      const double turn = 2.0 * std::numbers::pi * segment / segments;
      normals.emplace_back(
          std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
    }
  }
  normals.emplace_back(0.0f, 0.0f, -1.0f);
  const auto at = [&](int ring, int segment) {
    return static_cast<std::uint32_t>(1 + (ring - 1) * segments + segment % segments);
  };
  const auto south = static_cast<std::uint32_t>(normals.size() - 1);
  std::vector<glm::uvec3> triangles;
  for (int segment = 0; segment < segments; ++segment) {
    triangles.emplace_back(0, at(1, segment), at(1, segment + 1));
    for (int ring = 1; ring + 1 < rings; ++ring) {
      triangles.emplace_back(at(ring, segment), at(ring + 1, segment), at(ring + 1, segment + 1));
      triangles.emplace_back(at(ring, segment), at(ring + 1, segment + 1), at(ring, segment + 1));
    }
    triangles.emplace_back(at(rings - 1, segment), south, at(rings - 1, segment + 1));
  }
  std::vector<glm::vec3> positions;
  for (const glm::vec3& normal : normals) positions.push_back(centre + radius * normal);
  Mesh mesh = MeshOf(std::move(positions), std::move(triangles), std::move(material));
  mesh.normals = std::move(normals);
  return mesh;
}

Mesh Ground(float half_size, float z, Material material) {
  return MeshOf({{-half_size, -half_size, z},
                 {half_size, -half_size, z},
                 {half_size, half_size, z},
                 {-half_size, half_size, z}},
                {{0, 1, 2}, {0, 2, 3}},
                std::move(material));
}

Mesh Join(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  const auto vertices = static_cast<std::uint32_t>(a.positions_m.size());
  const auto materials = static_cast<std::uint32_t>(a.materials.size());
  const auto groups = static_cast<std::uint32_t>(a.group_names.size());
  both.positions_m.insert(both.positions_m.end(), b.positions_m.begin(), b.positions_m.end());
  both.normals.insert(both.normals.end(), b.normals.begin(), b.normals.end());
  both.materials.insert(both.materials.end(), b.materials.begin(), b.materials.end());
  both.group_names.insert(both.group_names.end(), b.group_names.begin(), b.group_names.end());
  for (const glm::uvec3& t : b.triangles) both.triangles.push_back(t + vertices);
  for (const std::uint32_t m : b.triangle_material) both.triangle_material.push_back(m + materials);
  for (const std::uint32_t g : b.triangle_group) both.triangle_group.push_back(g + groups);
  return both;
}

Mesh TurnedInsideOut(Mesh mesh) {
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  for (glm::vec3& normal : mesh.normals) normal = -normal;
  return mesh;
}

Camera LookAt(
    const glm::dvec3& eye, const glm::dvec3& target, int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.intrinsics = {
      width_px, height_px, focal_px, focal_px, 0.5 * (width_px - 1), 0.5 * (height_px - 1), {}};
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 up =
      std::abs(forward.z) < 0.999 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  const glm::dvec3 down = glm::cross(forward, right);
  const glm::dmat3 camera_from_world_rotation = glm::transpose(glm::dmat3(right, down, forward));
  camera.camera_from_world = glm::dmat4(camera_from_world_rotation);
  camera.camera_from_world[3] = glm::dvec4(-(camera_from_world_rotation * eye), 1.0);
  return camera;
}

glm::dvec3 DirectionOf(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180.0;
  const double elevation = elevation_deg * std::numbers::pi / 180.0;
  return {std::sin(azimuth) * std::cos(elevation),
          std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

std::optional<std::filesystem::path> SharedFile(const std::filesystem::path& relative) {
  const std::filesystem::path file = std::filesystem::path(PLEINAIR_SHARED_DIR) / relative;
  if (!std::filesystem::exists(file)) return std::nullopt;
  return file;
}

}  // namespace pleinair::test

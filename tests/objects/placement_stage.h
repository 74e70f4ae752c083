// Surfaces to put objects onto, objects to put there, and what holds of one that rests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>

#include "objects/object_placement.h"
#include "objects/surface_point.h"
#include "scene/mesh.h"
#include "scene/ray_caster.h"
#include "tests/scene/box_mesh.h"

namespace pleinair::placement_stage {

constexpr double kPi = 3.14159265358979323846;

// A mesh of one group a call.
class Builder {
 public:
  Builder& Quad(const std::string& group,
                const glm::vec3& a,
                const glm::vec3& b,
                const glm::vec3& c,
                const glm::vec3& d) {
    const auto first = static_cast<std::uint32_t>(mesh_.positions_m.size());
    for (const glm::vec3& corner : {a, b, c, d}) {
      mesh_.positions_m.push_back(corner);
      mesh_.normals.emplace_back(0.0f, 0.0f, 1.0f);
    }
    Triangle(group, {first, first + 1, first + 2});
    return Triangle(group, {first, first + 2, first + 3});
  }
  Builder& Box(const std::string& group, const glm::vec3& lower, const glm::vec3& upper) {
    const Mesh box = BoxMesh(lower, upper);
    const auto first = static_cast<std::uint32_t>(mesh_.positions_m.size());
    for (const glm::vec3& corner : box.positions_m) {
      mesh_.positions_m.push_back(corner);
      mesh_.normals.emplace_back(0.0f, 0.0f, 1.0f);
    }
    for (const glm::uvec3& triangle : box.triangles) Triangle(group, triangle + first);
    return *this;
  }
  Builder& Triangle(const std::string& group, const glm::uvec3& triangle) {
    const auto known = std::find(mesh_.group_names.begin(), mesh_.group_names.end(), group);
    mesh_.triangle_group.push_back(static_cast<std::uint32_t>(known - mesh_.group_names.begin()));
    if (known == mesh_.group_names.end()) mesh_.group_names.push_back(group);
    mesh_.triangles.push_back(triangle);
    mesh_.triangle_material.push_back(0);
    return *this;
  }
  Mesh Done() {
    mesh_.materials.resize(1);
    return mesh_;
  }

 private:
  Mesh mesh_;
};

inline Builder Floor() {
  return Builder().Quad("floor", {-10, -10, 0}, {10, -10, 0}, {10, 10, 0}, {-10, 10, 0});
}

// Steps of 0.17 m by 0.28 m that rise towards +Y: the first riser stands at y = 0.
inline Mesh Stairs() {
  Builder builder = Floor();
  for (int step = 0; step < 6; ++step) {
    const float y = 0.28f * static_cast<float>(step);
    builder.Box("stairs", {-2, y, 0.0f}, {2, 1.68f, 0.17f * static_cast<float>(step + 1)});
  }
  return builder.Done();
}

// About the origin, with its poles along Z; two triangles a cell.
inline Mesh SphereMesh(float radius_m, int rings, int sectors) {
  Mesh mesh;
  for (int ring = 0; ring <= rings; ++ring) {
    const double polar = kPi * ring / rings;
    for (int sector = 0; sector < sectors; ++sector) {
      const double azimuth = 2.0 * kPi * sector / sectors;
      const glm::vec3 direction(std::sin(polar) * std::cos(azimuth),
                                std::sin(polar) * std::sin(azimuth),
                                std::cos(polar));
      mesh.positions_m.push_back(radius_m * direction);
      mesh.normals.push_back(direction);
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    for (int sector = 0; sector < sectors; ++sector) {
      const auto at = [&](int r, int s) {
        return static_cast<std::uint32_t>(r * sectors + s % sectors);
      };
      mesh.triangles.push_back({at(ring, sector), at(ring + 1, sector), at(ring + 1, sector + 1)});
      mesh.triangles.push_back({at(ring, sector), at(ring + 1, sector + 1), at(ring, sector + 1)});
    }
  }
  mesh.triangle_material.assign(mesh.triangles.size(), 0);
  mesh.triangle_group.assign(mesh.triangles.size(), 0);
  mesh.materials.resize(1);
  mesh.group_names = {"sphere"};
  return mesh;
}

// Whether a line from `from` to `to` passes through the triangle (Moeller and Trumbore).
inline bool Passes(const glm::dvec3& from,
                   const glm::dvec3& to,
                   const std::array<glm::dvec3, 3>& triangle) {
  const glm::dvec3 way = to - from;
  const glm::dvec3 e1 = triangle[1] - triangle[0];
  const glm::dvec3 e2 = triangle[2] - triangle[0];
  const glm::dvec3 p = glm::cross(way, e2);
  const double determinant = glm::dot(e1, p);
  if (determinant == 0.0) return false;
  const glm::dvec3 s = from - triangle[0];
  const double u = glm::dot(s, p) / determinant;
  const glm::dvec3 q = glm::cross(s, e1);
  const double v = glm::dot(way, q) / determinant;
  const double t = glm::dot(e2, q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= 1.0;
}

inline std::array<glm::dvec3, 3> CornersOf(const Mesh& mesh, const glm::uvec3& triangle) {
  return {glm::dvec3(mesh.positions_m[triangle.x]),
          glm::dvec3(mesh.positions_m[triangle.y]),
          glm::dvec3(mesh.positions_m[triangle.z])};
}

// Edges of one mesh that pass through the other's faces, either way, by brute force.
inline int Crossings(const Mesh& a, const Mesh& b) {
  int crossings = 0;
  const auto count = [&](const Mesh& edges, const Mesh& faces) {
    std::vector<std::array<glm::dvec3, 3>> corners;
    for (const glm::uvec3& face : faces.triangles) corners.push_back(CornersOf(faces, face));
    const BoundingBox box = BoundingBoxOf(edges);
    for (const auto& face : corners) {
      const auto [lower_x, upper_x] = std::minmax({face[0].x, face[1].x, face[2].x});
      const auto [lower_y, upper_y] = std::minmax({face[0].y, face[1].y, face[2].y});
      const auto [lower_z, upper_z] = std::minmax({face[0].z, face[1].z, face[2].z});
      if (lower_x > box.upper_m.x || upper_x < box.lower_m.x || lower_y > box.upper_m.y ||
          upper_y < box.lower_m.y || lower_z > box.upper_m.z || upper_z < box.lower_m.z) {
        continue;
      }
      for (const glm::uvec3& edge : edges.triangles) {
        const auto at = CornersOf(edges, edge);
        for (std::size_t i = 0; i < 3; ++i) crossings += Passes(at[i], at[(i + 1) % 3], face);
      }
    }
  };
  count(a, b);
  count(b, a);
  return crossings;
}

// Of a mesh whose solids are closed: by the faces over the point, along a line that meets no edge.
inline bool IsInside(const Mesh& solids, const glm::dvec3& point) {
  int faces = 0;
  for (const glm::uvec3& triangle : solids.triangles) {
    faces += Passes(point, point + glm::dvec3(137.1, 91.7, 1013.3), CornersOf(solids, triangle));
  }
  return faces % 2 == 1;
}

// Between an object and a mesh that do not cross, by points of the edges of either, 0.5 mm apart
// where it matters.
inline double Gap(const Mesh& object, const Mesh& mesh) {
  float gap = std::numeric_limits<float>::infinity();
  const auto look = [&](const Mesh& edges, const Mesh& faces) {
    const RayCaster to_faces(faces);
    for (const glm::uvec3& triangle : edges.triangles) {
      for (int i = 0; i < 3; ++i) {
        const glm::vec3 from = edges.positions_m[triangle[i]];
        const glm::vec3 way = edges.positions_m[triangle[(i + 1) % 3]] - from;
        const float half = 0.5f * glm::length(way);
        if (to_faces.DistanceTo(from + 0.5f * way, gap + half) >= gap + half) continue;
        const int pieces = static_cast<int>(std::ceil(2.0f * half / 5e-4f));
        for (int piece = 0; piece <= pieces && gap > 2e-4f; ++piece) {
          const float share = static_cast<float>(piece) / static_cast<float>(std::max(pieces, 1));
          gap = std::min(gap, to_faces.DistanceTo(from + share * way, gap));
        }
      }
    }
  };
  look(object, mesh);
  if (gap > 1e-3f) look(mesh, object);
  return gap;
}

inline double AngleDeg(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180.0 / kPi;
}

}  // namespace pleinair::placement_stage

#include "calib/mesh_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

constexpr double kFlatCosine = 0.99939;    // 2 degrees.
constexpr double kCreaseCosine = 0.90631;  // 25 degrees.

struct Side {
  std::uint32_t triangle;
  std::uint32_t opposite;  // The vertex that is not on the edge.
};

// For each vertex the first one at its place.
std::vector<std::uint32_t> FirstAtPlace(const Mesh& mesh) {
  std::map<std::array<float, 3>, std::uint32_t> first;
  std::vector<std::uint32_t> at;
  for (std::uint32_t i = 0; i < mesh.positions_m.size(); ++i) {
    const glm::vec3& p = mesh.positions_m[i];
    at.push_back(first.try_emplace({p.x, p.y, p.z}, i).first->second);
  }
  return at;
}

// Whether the surface of `side` continues beyond the edge, in its plane and material.
bool GoesOn(const Mesh& mesh,
            const RayCaster& rays,
            const glm::dvec3& from,
            const glm::dvec3& to,
            const Side& side) {
  const glm::dvec3 middle = 0.5 * (from + to);
  const glm::dvec3 along = glm::normalize(to - from);
  const glm::dvec3 inward = glm::dvec3(mesh.positions_m[side.opposite]) - middle;
  const glm::dvec3 across = inward - glm::dot(inward, along) * along;
  const double size = glm::length(across);
  if (!(size > 0.0)) return true;  // A triangle without area.
  // A step that is small for the triangle, and large for single precision.
  const double step = 0.01 * std::min(size, glm::distance(from, to));
  const glm::dvec3 normal(TriangleNormal(mesh, side.triangle));
  const glm::dvec3 beyond = middle - step / size * across + step * normal;
  const auto hit =
      rays.Intersect(glm::vec3(beyond), glm::vec3(-normal), static_cast<float>(2.0 * step));
  return hit && std::abs(glm::dot(glm::dvec3(hit->geometric_normal), normal)) > kFlatCosine &&
         std::abs(hit->distance_m - step) < 0.1 * step &&
         mesh.triangle_material[hit->triangle] == mesh.triangle_material[side.triangle];
}

}  // namespace

bool MeshEdge::IsOutlineFrom(const glm::dvec3& eye_m) const {
  const glm::dvec3 to_eye = eye_m - from_m;
  return (glm::dot(normal_a, to_eye) > 0.0) != (glm::dot(normal_b, to_eye) > 0.0);
}

std::vector<MeshEdge> EdgesOf(const Mesh& mesh, const RayCaster& rays) {
  const std::vector<std::uint32_t> at = FirstAtPlace(mesh);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Side>> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = at[mesh.triangles[t][c]];
      const std::uint32_t b = at[mesh.triangles[t][(c + 1) % 3]];
      if (a == b) continue;
      sides[std::minmax(a, b)].push_back({t, at[mesh.triangles[t][(c + 2) % 3]]});
    }
  }
  std::vector<MeshEdge> edges;
  for (const auto& [ends, faces] : sides) {
    MeshEdge edge;
    edge.from_m = mesh.positions_m[ends.first];
    edge.to_m = mesh.positions_m[ends.second];
    if (faces.size() == 1) {
      if (GoesOn(mesh, rays, edge.from_m, edge.to_m, faces[0])) continue;
    } else {
      // The sharpest bend of those that meet there; both sides of a sheet are one direction.
      double cosine = 1.0;
      bool one_material = true;
      edge.normal_a = TriangleNormal(mesh, faces[0].triangle);
      edge.normal_b = TriangleNormal(mesh, faces[1].triangle);
      for (const Side& side : faces) {
        const glm::dvec3 normal(TriangleNormal(mesh, side.triangle));
        if (normal == glm::dvec3(0.0)) continue;
        cosine = std::min(cosine, glm::dot(edge.normal_a, normal));
        one_material &=
            mesh.triangle_material[side.triangle] == mesh.triangle_material[faces[0].triangle];
      }
      if (one_material && cosine > kFlatCosine) continue;
      edge.is_sharp = !one_material || cosine < kCreaseCosine || faces.size() > 2;
    }
    edges.push_back(edge);
  }
  return edges;
}

std::vector<MeshEdge> JoinedEdges(std::span<const MeshEdge> edges) {
  using Place = std::array<double, 3>;
  const auto key = [](const glm::dvec3& at) { return Place{at.x, at.y, at.z}; };
  std::vector<MeshEdge> joined(edges.begin(), edges.end());
  std::vector<bool> is_part(joined.size(), false);
  std::map<Place, std::vector<std::size_t>> ending_at;
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (!joined[i].is_sharp) continue;
    ending_at[key(joined[i].from_m)].push_back(i);
    ending_at[key(joined[i].to_m)].push_back(i);
  }
  // Edge i takes over what continues it beyond `end`, until nothing does.
  const auto extend = [&](std::size_t i, glm::dvec3 MeshEdge::*end, const glm::dvec3& from) {
    for (bool grew = true; grew;) {
      grew = false;
      const glm::dvec3 direction = glm::normalize(joined[i].*end - from);
      for (const std::size_t next : ending_at[key(joined[i].*end)]) {
        if (next == i || is_part[next]) continue;
        const bool begins_here = joined[next].from_m == joined[i].*end;
        if (!begins_here && joined[next].to_m != joined[i].*end) continue;  // It has grown.
        const glm::dvec3 far = begins_here ? joined[next].to_m : joined[next].from_m;
        if (!(glm::dot(glm::normalize(far - joined[i].*end), direction) > kFlatCosine)) continue;
        is_part[next] = true;
        joined[i].*end = far;
        grew = true;
        break;
      }
    }
  };
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (!joined[i].is_sharp || is_part[i]) continue;
    extend(i, &MeshEdge::to_m, joined[i].from_m);
    extend(i, &MeshEdge::from_m, joined[i].to_m);
  }
  std::vector<MeshEdge> kept;
  for (std::size_t i = 0; i < joined.size(); ++i) {
    if (!is_part[i]) kept.push_back(joined[i]);
  }
  return kept;
}

}  // namespace pleinair

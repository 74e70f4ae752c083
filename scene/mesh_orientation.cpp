#include "scene/mesh_orientation.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "scene/disjoint_sets.h"

namespace pleinair {
namespace {

using Position = std::array<float, 3>;

struct DirectedEdge {
  std::uint32_t lower = 0;
  std::uint32_t higher = 0;
  std::uint32_t triangle = 0;
  int sign = 0;  // 1 where the triangle runs from lower to higher.
};

// All triangles' edges over joined positions, sorted so that equal ones are neighbours.
std::vector<DirectedEdge> EdgesOf(const Mesh& mesh) {
  std::map<Position, std::uint32_t> joined;
  std::vector<std::uint32_t> place(mesh.positions_m.size());
  for (std::size_t i = 0; i < place.size(); ++i) {
    const glm::vec3& p = mesh.positions_m[i];
    place[i] = joined.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(joined.size()))
                   .first->second;
  }
  std::vector<DirectedEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t from = place[mesh.triangles[t][corner]];
      const std::uint32_t to = place[mesh.triangles[t][(corner + 1) % 3]];
      edges.push_back({std::min(from, to), std::max(from, to), t, from < to ? 1 : -1});
    }
  }
  std::stable_sort(edges.begin(), edges.end(), [](const DirectedEdge& a, const DirectedEdge& b) {
    return std::pair(a.lower, a.higher) < std::pair(b.lower, b.higher);
  });
  return edges;
}

}  // namespace

std::int64_t TurnClosedPartsOutward(Mesh& mesh) {
  const std::vector<DirectedEdge> edges = EdgesOf(mesh);
  const auto same = [](const DirectedEdge& a, const DirectedEdge& b) {
    return a.lower == b.lower && a.higher == b.higher;
  };
  std::vector<std::uint32_t> part(mesh.triangles.size());
  std::iota(part.begin(), part.end(), 0u);
  for (std::size_t i = 1; i < edges.size(); ++i) {
    if (!same(edges[i - 1], edges[i])) continue;
    part[RootOf(part, edges[i].triangle)] = RootOf(part, edges[i - 1].triangle);
  }
  for (std::uint32_t t = 0; t < part.size(); ++t) part[t] = RootOf(part, t);

  std::vector<std::uint8_t> is_open(part.size(), 0);
  for (std::size_t i = 0; i < edges.size();) {
    int sum = 0;
    const std::size_t first = i;
    for (; i < edges.size() && same(edges[first], edges[i]); ++i) sum += edges[i].sign;
    if (sum != 0) is_open[part[edges[first].triangle]] = 1;
  }
  std::vector<double> volume(part.size(), 0.0);
  std::vector<double> agreement(part.size(), 0.0);  // Agreement of normals with winding.
  for (std::uint32_t t = 0; t < part.size(); ++t) {
    const glm::uvec3& corners = mesh.triangles[t];
    const glm::dvec3 a(mesh.positions_m[corners.x]);
    const glm::dvec3 area_normal = glm::cross(glm::dvec3(mesh.positions_m[corners.y]) - a,
                                              glm::dvec3(mesh.positions_m[corners.z]) - a);
    const glm::dvec3 apex(mesh.positions_m[mesh.triangles[part[t]].x]);
    volume[part[t]] += glm::dot(a - apex, area_normal);
    if (mesh.normals.empty()) continue;
    for (int corner = 0; corner < 3; ++corner) {
      agreement[part[t]] += glm::dot(glm::dvec3(mesh.normals[corners[corner]]), area_normal);
    }
  }

  // A vertex that an unturned triangle uses too is doubled.
  const auto is_turned = [&](std::uint32_t t) {
    return is_open[part[t]] == 0 && volume[part[t]] < 0.0;
  };
  std::vector<std::uint8_t> is_kept(mesh.positions_m.size(), 0);
  for (std::uint32_t t = 0; t < part.size(); ++t) {
    for (int corner = 0; corner < 3 && !is_turned(t); ++corner) {
      is_kept[mesh.triangles[t][corner]] = 1;
    }
  }
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> turned_vertex(mesh.positions_m.size(), kNone);
  std::int64_t turned = 0;
  for (std::uint32_t t = 0; t < part.size(); ++t) {
    if (!is_turned(t)) continue;
    ++turned;
    glm::uvec3& corners = mesh.triangles[t];
    std::swap(corners.y, corners.z);
    if (!mesh.triangle_colours.empty()) {
      TriangleColours& colours = mesh.triangle_colours[t];
      std::swap(colours.texture_uv[1], colours.texture_uv[2]);
      std::swap(colours.vertex_colour[1], colours.vertex_colour[2]);
    }
    if (mesh.normals.empty()) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = corners[corner];
      if (turned_vertex[vertex] == kNone) {
        const glm::vec3 normal =
            agreement[part[t]] > 0.0 ? -mesh.normals[vertex] : mesh.normals[vertex];
        if (is_kept[vertex] != 0) {
          turned_vertex[vertex] = static_cast<std::uint32_t>(mesh.positions_m.size());
          const glm::vec3 position = mesh.positions_m[vertex];
          mesh.positions_m.push_back(position);
          mesh.normals.push_back(normal);
        } else {
          turned_vertex[vertex] = vertex;
          mesh.normals[vertex] = normal;
        }
      }
      corners[corner] = turned_vertex[vertex];
    }
  }
  return turned;
}

}  // namespace pleinair

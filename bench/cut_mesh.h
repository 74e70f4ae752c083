// The same surface with more triangles, or fewer.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/mesh.h"

namespace pleinair {

// Each of the first `count` triangles becomes four.
inline Mesh CutInFour(const Mesh& mesh, std::size_t count) {
  Mesh cut = mesh;
  cut.triangles.clear();
  cut.triangle_material.clear();
  cut.triangle_group.clear();
  const auto add = [&](std::size_t of, const glm::uvec3& triangle) {
    cut.triangles.push_back(triangle);
    cut.triangle_material.push_back(mesh.triangle_material[of]);
    cut.triangle_group.push_back(mesh.triangle_group[of]);
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    if (t >= count) {
      add(t, v);
      continue;
    }
    const auto first = static_cast<std::uint32_t>(cut.positions_m.size());
    for (int edge = 0; edge < 3; ++edge) {
      const std::uint32_t a = v[edge];
      const std::uint32_t b = v[(edge + 1) % 3];
      cut.positions_m.push_back(0.5f * (mesh.positions_m[a] + mesh.positions_m[b]));
      cut.normals.push_back(glm::normalize(mesh.normals[a] + mesh.normals[b]));
    }
    add(t, {v.x, first, first + 2});
    add(t, {first, v.y, first + 1});
    add(t, {first + 2, first + 1, v.z});
    add(t, {first, first + 1, first + 2});
  }
  return cut;
}

// Vertices within a cell of a grid become one, in their middle.
inline Mesh Clustered(const Mesh& mesh, float cell_m) {
  Mesh coarse = mesh;
  coarse.positions_m.clear();
  coarse.normals.clear();
  coarse.triangles.clear();
  coarse.triangle_material.clear();
  coarse.triangle_group.clear();
  std::map<std::array<int, 3>, std::uint32_t> cells;
  std::vector<std::uint32_t> cell_of;
  std::vector<float> counts;
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    const glm::vec3 cell = glm::floor(mesh.positions_m[i] / cell_m);
    const auto [entry, is_new] = cells.try_emplace(
        {static_cast<int>(cell.x), static_cast<int>(cell.y), static_cast<int>(cell.z)},
        static_cast<std::uint32_t>(counts.size()));
    if (is_new) {
      coarse.positions_m.emplace_back(0.0f);
      coarse.normals.emplace_back(0.0f);
      counts.push_back(0.0f);
    }
    cell_of.push_back(entry->second);
    coarse.positions_m[entry->second] += mesh.positions_m[i];
    coarse.normals[entry->second] += mesh.normals[i];
    counts[entry->second] += 1.0f;
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    coarse.positions_m[i] /= counts[i];
    const float length = glm::length(coarse.normals[i]);
    coarse.normals[i] = length > 0.0f ? coarse.normals[i] / length : glm::vec3(0.0f, 0.0f, 1.0f);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    const glm::uvec3 merged(cell_of[v.x], cell_of[v.y], cell_of[v.z]);
    if (merged.x == merged.y || merged.y == merged.z || merged.z == merged.x) continue;
    coarse.triangles.push_back(merged);
    coarse.triangle_material.push_back(mesh.triangle_material[t]);
    coarse.triangle_group.push_back(mesh.triangle_group[t]);
  }
  return coarse;
}

// `mesh` with `count` triangles: to 1 % where it has more, else exactly or with up to two more.
inline Mesh WithTriangles(Mesh mesh, std::size_t count) {
  while (4 * mesh.triangles.size() <= count) mesh = CutInFour(mesh, mesh.triangles.size());
  if (mesh.triangles.size() <= count) {
    return CutInFour(mesh, (count - mesh.triangles.size() + 2) / 3);
  }
  const BoundingBox box = BoundingBoxOf(mesh);
  float fine_m = 0.0f;
  float coarse_m = glm::length(box.upper_m - box.lower_m);
  Mesh clustered = mesh;
  for (int step = 0; step < 24; ++step) {
    const float cell_m = 0.5f * (fine_m + coarse_m);
    clustered = Clustered(mesh, cell_m);
    const auto has = static_cast<double>(clustered.triangles.size());
    if (std::abs(has / static_cast<double>(count) - 1.0) <= 0.01) break;
    (clustered.triangles.size() > count ? fine_m : coarse_m) = cell_m;
  }
  return clustered;
}

}  // namespace pleinair

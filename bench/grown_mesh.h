// A site's mesh as finer surveys give it: the same place in more triangles, clean or as made from
// photographs.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "relight/transport/patch_refinement.h"
#include "scene/low_discrepancy.h"
#include "scene/mesh.h"

namespace pleinair {

// Edges grow by this share of their length for each metre from the focus, as photographs show what
// is near in more detail.
inline constexpr double kEdgeGrowthPerM = 0.1;

// The mesh cut along its edges into `count` triangles, to 2 %, smallest at the focus; neighbours
// stay joined. Throws std::invalid_argument where the mesh has more.
inline Mesh Grown(const Mesh& mesh, const glm::dvec3& focus_m, std::size_t count) {
  constexpr double kShortestM = 1e-3;
  constexpr double kLongestM = 1e3;
  const std::size_t most = count + count / 50;
  double fine_m = kShortestM;
  double coarse_m = kLongestM;
  Mesh best = mesh;
  for (int step = 0; step < 40 && best.triangles.size() + count / 50 < count; ++step) {
    const double edge_m = std::sqrt(fine_m * coarse_m);
    std::optional<RefinedMesh> refined = TryRefineMesh(
        mesh,
        [&](const glm::vec3& at_m) {
          return edge_m * (1.0 + kEdgeGrowthPerM * glm::distance(glm::dvec3(at_m), focus_m));
        },
        most);
    (refined ? coarse_m : fine_m) = edge_m;
    if (refined) best = std::move(refined->mesh);
  }
  if (best.triangles.size() > most) {
    throw std::invalid_argument("--triangles: " + std::to_string(count) + " are fewer than the " +
                                std::to_string(mesh.triangles.size()) + " of the mesh");
  }
  return best;
}

// What a mesh from photographs is like, beside its many triangles.
struct PhotogrammetryFaults {
  double noise_of_edge = 0.1;   // Standard deviation of a vertex over its shortest edge,
  double most_noise_m = 0.02;   // but at most this: cameras cause it, not triangles.
  double sliver_share = 0.02;   // Share of vertices moved along an edge almost onto the next one.
  int holes = 60;               // Balls about points of the surface, most of them near the focus,
  double hole_radius_m = 0.25;  // with this radius at the focus; it grows as edges do.
  std::uint64_t seed = 1;
};

namespace grown_mesh_internal {

// Equal for vertices of equal place: what is stored twice stays joined.
inline std::uint64_t HashOfPlace(const glm::vec3& at_m, std::uint64_t seed) {
  std::uint64_t hash = HashBits(seed);
  for (int axis = 0; axis < 3; ++axis) {
    hash = HashBits(hash ^ std::bit_cast<std::uint32_t>(at_m[axis] + 0.0f));
  }
  return hash;
}

// Standard normal (Box and Muller 1958).
inline double NormalFromHash(std::uint64_t hash) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - UnitFromHash(hash)));
  return radius * std::cos(2.0 * std::numbers::pi * UnitFromHash(HashBits(hash)));
}

struct Ball {
  glm::dvec3 centre_m;
  double radius_m;
};

// Holes of the surface, whatever its triangles: the same for each refinement of a mesh.
inline std::vector<Ball> Holes(const Mesh& source,
                               const glm::dvec3& focus_m,
                               const PhotogrammetryFaults& faults) {
  std::vector<double> area_until;
  double area = 0.0;
  for (const glm::uvec3& v : source.triangles) {
    const glm::dvec3 a(source.positions_m[v.x]);
    area += glm::length(glm::cross(glm::dvec3(source.positions_m[v.y]) - a,
                                   glm::dvec3(source.positions_m[v.z]) - a));
    area_until.push_back(area);
  }
  std::vector<Ball> holes;
  for (std::uint64_t draw = 0; holes.size() < static_cast<std::size_t>(faults.holes); ++draw) {
    const std::uint64_t hash = HashBits(HashBits(faults.seed) ^ draw);
    const auto chosen =
        std::upper_bound(area_until.begin(), area_until.end() - 1, area * UnitFromHash(hash));
    const glm::uvec3& v = source.triangles[static_cast<std::size_t>(chosen - area_until.begin())];
    const std::uint64_t next = HashBits(hash);
    const glm::dvec3 centre_m(TrianglePoint(source.positions_m[v.x],
                                            source.positions_m[v.y],
                                            source.positions_m[v.z],
                                            {UnitFromHash(next), UnitFromHash(HashBits(next))}));
    const double size = 1.0 + kEdgeGrowthPerM * glm::distance(centre_m, focus_m);
    if (UnitFromHash(HashBits(HashBits(next))) * size * size > 1.0) continue;
    holes.push_back({centre_m, faults.hole_radius_m * size});
  }
  return holes;
}

}  // namespace grown_mesh_internal

// `mesh`, a refinement of `source`, with the faults. Its vertices have no normals, as in most files
// of that kind.
inline Mesh AsFromPhotographs(const Mesh& source,
                              Mesh mesh,
                              const glm::dvec3& focus_m,
                              const PhotogrammetryFaults& faults) {
  using namespace grown_mesh_internal;
  const std::vector<Ball> holes = Holes(source, focus_m, faults);
  const std::vector<glm::vec3> clean_m = mesh.positions_m;
  // The other end of each vertex's shortest edge.
  std::vector<glm::vec3> next_m(clean_m.size());
  std::vector<float> edge_m(clean_m.size(), std::numeric_limits<float>::infinity());
  for (const glm::uvec3& v : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      for (const std::uint32_t other : {v[(corner + 1) % 3], v[(corner + 2) % 3]}) {
        const float length_m = glm::distance(clean_m[v[corner]], clean_m[other]);
        if (!(length_m < edge_m[v[corner]])) continue;
        edge_m[v[corner]] = length_m;
        next_m[v[corner]] = clean_m[other];
      }
    }
  }
  for (std::size_t i = 0; i < clean_m.size(); ++i) {
    const std::uint64_t hash = HashOfPlace(clean_m[i], faults.seed);
    const double noise_m =
        std::min(faults.noise_of_edge * static_cast<double>(edge_m[i]), faults.most_noise_m);
    glm::dvec3 moved_m(clean_m[i]);
    constexpr double kAlmost = 0.97;
    if (UnitFromHash(hash) < faults.sliver_share) {
      moved_m += kAlmost * (glm::dvec3(next_m[i]) - moved_m);
    }
    for (int axis = 0; axis < 3; ++axis) {
      moved_m[axis] += noise_m * NormalFromHash(HashBits(hash ^ static_cast<unsigned>(axis + 1)));
    }
    mesh.positions_m[i] = glm::vec3(moved_m);
  }
  mesh.normals.assign(clean_m.size(), glm::vec3(0.0f));
  Mesh pierced = mesh;
  pierced.triangles.clear();
  pierced.triangle_material.clear();
  pierced.triangle_group.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& v = mesh.triangles[t];
    const glm::dvec3 middle_m =
        (glm::dvec3(clean_m[v.x]) + glm::dvec3(clean_m[v.y]) + glm::dvec3(clean_m[v.z])) / 3.0;
    const bool in_hole = std::any_of(holes.begin(), holes.end(), [&](const Ball& ball) {
      return glm::distance(middle_m, ball.centre_m) < ball.radius_m;
    });
    if (in_hole) continue;
    pierced.triangles.push_back(v);
    pierced.triangle_material.push_back(mesh.triangle_material[t]);
    pierced.triangle_group.push_back(mesh.triangle_group[t]);
  }
  return pierced;
}

}  // namespace pleinair

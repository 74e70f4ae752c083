#include "scene/internal/mesh_repair.h"

#include <algorithm>
#include <bit>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/internal/mesh_normals.h"
#include "scene/is_finite.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// A triangle lower than four rounding errors of its coordinates: that much collinear corners are
// apart after rounding to float, and its normal means nothing.
constexpr double kDegenerateShare = 0x1p-22;

template <std::size_t kCount>
using Key = std::array<std::uint32_t, kCount>;

// Equal numbers have equal keys: -0 is 0.
Key<3> BitsOf(const glm::vec3& v) {
  return {std::bit_cast<std::uint32_t>(v.x + 0.0f),
          std::bit_cast<std::uint32_t>(v.y + 0.0f),
          std::bit_cast<std::uint32_t>(v.z + 0.0f)};
}

bool IsDegenerate(const std::array<glm::vec3, 3>& corners) {
  const glm::dvec3 a(corners[0]);
  const glm::dvec3 b(corners[1]);
  const glm::dvec3 c(corners[2]);
  const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  double largest = 0.0;
  for (const glm::dvec3& corner : {a, b, c}) {
    const glm::dvec3 size = glm::abs(corner);
    largest = std::max({largest, size.x, size.y, size.z});
  }
  const double twice_area = glm::length(glm::cross(b - a, c - a));
  return !(twice_area > kDegenerateShare * largest * longest);
}

// The triangle's corners, smallest first, in their cyclic order: the same for the same triangle
// wherever its list starts, another for the opposite winding.
Key<3> CanonicalOrder(const glm::uvec3& triangle) {
  Key<3> key = {triangle.x, triangle.y, triangle.z};
  std::rotate(key.begin(), std::min_element(key.begin(), key.end()), key.end());
  return key;
}

// The remaining loose triangles, corners as indices of distinct positions.
struct Kept {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<std::size_t> source;  // Into the loose triangles.
};

Kept KeepSound(std::span<const LooseTriangle> loose, MeshReport& report) {
  Kept kept;
  std::unordered_map<Key<3>, std::uint32_t, HashOfWords> index_of;
  std::unordered_set<Key<3>, HashOfWords> seen;
  for (std::size_t i = 0; i < loose.size(); ++i) {
    std::array<glm::vec3, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) corners[c] = glm::vec3(loose[i].corners[c].position_m);
    if (!IsFinite(corners[0]) || !IsFinite(corners[1]) || !IsFinite(corners[2])) {
      ++report.non_finite_triangles_removed;
      continue;
    }
    if (IsDegenerate(corners)) {
      ++report.degenerate_triangles_removed;
      continue;
    }
    glm::uvec3 triangle;
    for (int c = 0; c < 3; ++c) {
      const glm::vec3& position = corners[static_cast<std::size_t>(c)];
      const auto next = static_cast<std::uint32_t>(kept.positions.size());
      const auto [entry, is_new] = index_of.emplace(BitsOf(position), next);
      if (is_new) kept.positions.push_back(position);
      triangle[c] = entry->second;
    }
    if (!seen.insert(CanonicalOrder(triangle)).second) {
      ++report.duplicate_triangles_removed;
      continue;
    }
    kept.triangles.push_back(triangle);
    kept.source.push_back(i);
  }
  return kept;
}

struct EdgeUse {
  int forward = 0;  // From the lower index to the higher.
  int backward = 0;
};

void CountEdges(std::span<const glm::uvec3> triangles, MeshReport& report) {
  std::unordered_map<Key<2>, EdgeUse, HashOfWords> edges;
  edges.reserve(triangles.size() * 3 / 2);
  for (const glm::uvec3& triangle : triangles) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t from = triangle[corner];
      const std::uint32_t to = triangle[(corner + 1) % 3];
      EdgeUse& use = edges[{std::min(from, to), std::max(from, to)}];
      ++(from < to ? use.forward : use.backward);
    }
  }
  for (const auto& [edge, use] : edges) {
    const int count = use.forward + use.backward;
    if (count == 1) ++report.open_edges;
    if (count > 2) ++report.non_manifold_edges;
    if (count == 2 && use.forward != use.backward) ++report.misoriented_edges;
  }
}

double SignedVolume(const Kept& kept) {
  double six_volumes = 0.0;
  const glm::dvec3 origin(kept.positions.front());
  for (const glm::uvec3& triangle : kept.triangles) {
    six_volumes += glm::dot(glm::dvec3(kept.positions[triangle.x]) - origin,
                            glm::cross(glm::dvec3(kept.positions[triangle.y]) - origin,
                                       glm::dvec3(kept.positions[triangle.z]) - origin));
  }
  return six_volumes / 6.0;
}

bool IsUsable(const glm::vec3& normal) {
  return IsFinite(normal) && glm::dot(glm::dvec3(normal), glm::dvec3(normal)) > 0.0;
}

}  // namespace

void RepairTriangles(std::span<const LooseTriangle> loose, Mesh& mesh, MeshReport& report) {
  const Kept kept = KeepSound(loose, report);
  if (kept.triangles.empty()) return;
  CountEdges(kept.triangles, report);
  if (report.IsClosedManifold() && report.misoriented_edges == 0 && SignedVolume(kept) < 0.0) {
    report.notes.emplace_back("the mesh is inside out: its winding is clockwise from outside");
  }
  const std::vector<std::array<glm::vec3, 3>> computed =
      CornerNormals(kept.positions, kept.triangles);

  const bool has_colours =
      std::any_of(loose.begin(), loose.end(), [](const LooseTriangle& t) { return t.is_by_place; });

  std::unordered_map<Key<4>, std::uint32_t, HashOfWords> index_of;
  std::int64_t contradictions = 0;
  for (std::size_t t = 0; t < kept.triangles.size(); ++t) {
    const LooseTriangle& source = loose[kept.source[t]];
    const glm::dvec3 a(kept.positions[kept.triangles[t].x]);
    const glm::dvec3 flat = glm::cross(glm::dvec3(kept.positions[kept.triangles[t].y]) - a,
                                       glm::dvec3(kept.positions[kept.triangles[t].z]) - a);
    glm::uvec3 triangle;
    for (int c = 0; c < 3; ++c) {
      const std::size_t corner = static_cast<std::size_t>(c);
      const glm::vec3& given = source.corners[corner].normal;
      const bool usable = IsUsable(given);
      const glm::vec3 normal =
          usable ? glm::vec3(glm::normalize(glm::dvec3(given))) : computed[t][corner];
      if (glm::dot(flat, glm::dvec3(normal)) < 0.0) ++contradictions;
      const Key<3> bits = BitsOf(normal);
      const auto next = static_cast<std::uint32_t>(mesh.positions_m.size());
      const auto [entry, is_new] =
          index_of.emplace(Key<4>{kept.triangles[t][c], bits[0], bits[1], bits[2]}, next);
      if (is_new) {
        mesh.positions_m.push_back(kept.positions[kept.triangles[t][c]]);
        mesh.normals.push_back(normal);
        if (!usable) ++report.normals_computed;
      }
      triangle[c] = entry->second;
    }
    mesh.triangles.push_back(triangle);
    mesh.triangle_material.push_back(source.material);
    mesh.triangle_group.push_back(source.group);
    if (has_colours) mesh.triangle_colours.push_back(source.colours);
  }
  if (contradictions > 0) {
    report.notes.push_back(std::to_string(contradictions) +
                           " corner normals point against their triangle's winding");
  }
}

}  // namespace pleinair

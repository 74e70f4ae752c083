#include "relight/transport/patch_refinement.h"

#include <array>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// Vertices of a mesh under refinement, with the midpoints made so far.
class Midpoints {
 public:
  Midpoints(Mesh& mesh, const TargetLength& target) : mesh_(mesh), target_(target) {}

  // An edge whose middle rounds to one of its ends cannot be cut, however long: far from the origin
  // floats are sparse.
  bool TooLong(std::uint32_t a, std::uint32_t b) const {
    const glm::vec3 middle = MiddleOf(a, b);
    if (middle == mesh_.positions_m[a] || middle == mesh_.positions_m[b]) return false;
    const glm::dvec3 from(mesh_.positions_m[a]);
    const glm::dvec3 to(mesh_.positions_m[b]);
    return glm::distance(from, to) > target_(glm::vec3(0.5 * (from + to)));
  }

  std::uint32_t Midpoint(std::uint32_t a, std::uint32_t b) {
    const std::uint64_t key = (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
    const auto found = midpoint_of_edge_.find(key);
    if (found != midpoint_of_edge_.end()) return found->second;
    const auto index = static_cast<std::uint32_t>(mesh_.positions_m.size());
    mesh_.positions_m.push_back(MiddleOf(a, b));
    if (!mesh_.normals.empty()) {
      const glm::vec3 sum = mesh_.normals[a] + mesh_.normals[b];
      const float length = glm::length(sum);
      mesh_.normals.push_back(length > 0.0f ? sum / length : mesh_.normals[a]);
    }
    midpoint_of_edge_.emplace(key, index);
    ends_.emplace_back(a, b);
    return index;
  }

  // Whether a vertex is a midpoint, and of which edge.
  std::optional<std::pair<std::uint32_t, std::uint32_t>> EndsOf(std::uint32_t vertex) const {
    const std::size_t first = mesh_.positions_m.size() - ends_.size();
    if (vertex < first) return std::nullopt;
    return ends_[vertex - first];
  }

  float Distance(std::uint32_t a, std::uint32_t b) const {
    return glm::distance(mesh_.positions_m[a], mesh_.positions_m[b]);
  }

 private:
  // a + b is the same as b + a: both copies of a doubled edge get the very same point.
  glm::vec3 MiddleOf(std::uint32_t a, std::uint32_t b) const {
    return 0.5f * (mesh_.positions_m[a] + mesh_.positions_m[b]);
  }

  Mesh& mesh_;
  const TargetLength& target_;
  std::unordered_map<std::uint64_t, std::uint32_t> midpoint_of_edge_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends_;  // Of each midpoint's edge.
};

// What a piece of a triangle is looked up in: a midpoint's place lies between those of its edge's
// ends, and these are corners of the triangle, or midpoints in it.
class ColoursOfPieces {
 public:
  ColoursOfPieces(const Mesh& source, const Midpoints& points) : source_(source), points_(points) {}

  TriangleColours Of(const glm::uvec3& piece, std::uint32_t source_triangle) {
    if (source_triangle != triangle_) {
      triangle_ = source_triangle;
      of_vertex_.clear();
      const TriangleColours& whole = source_.triangle_colours[source_triangle];
      for (std::size_t k = 0; k < 3; ++k) {
        of_vertex_[source_.triangles[source_triangle][static_cast<int>(k)]] = {
            whole.texture_uv[k], whole.vertex_colour[k]};
      }
    }
    TriangleColours colours;
    for (std::size_t k = 0; k < 3; ++k) {
      const AtVertex at = At(piece[static_cast<int>(k)]);
      colours.texture_uv[k] = at.texture_uv;
      colours.vertex_colour[k] = at.vertex_colour;
    }
    return colours;
  }

 private:
  struct AtVertex {
    glm::vec2 texture_uv{0.0f};
    glm::vec4 vertex_colour{1.0f};
  };

  AtVertex At(std::uint32_t vertex) {
    const auto known = of_vertex_.find(vertex);
    if (known != of_vertex_.end()) return known->second;
    AtVertex middle;
    if (const auto ends = points_.EndsOf(vertex)) {
      const AtVertex a = At(ends->first);
      const AtVertex b = At(ends->second);
      middle = {0.5f * (a.texture_uv + b.texture_uv), 0.5f * (a.vertex_colour + b.vertex_colour)};
    }
    of_vertex_.emplace(vertex, middle);
    return middle;
  }

  const Mesh& source_;
  const Midpoints& points_;
  std::uint32_t triangle_ = 0xffffffffu;
  std::unordered_map<std::uint32_t, AtVertex> of_vertex_;  // Of that triangle.
};

// The pieces of a triangle whose edges (v0 v1), (v1 v2), (v2 v0) are marked; winding is kept.
std::vector<glm::uvec3> Split(const glm::uvec3& v, std::array<bool, 3> marked, Midpoints& points) {
  const int count = marked[0] + marked[1] + marked[2];
  if (count == 3) {
    const std::uint32_t a = points.Midpoint(v[0], v[1]);
    const std::uint32_t b = points.Midpoint(v[1], v[2]);
    const std::uint32_t c = points.Midpoint(v[2], v[0]);
    return {{v[0], a, c}, {a, v[1], b}, {c, b, v[2]}, {a, b, c}};
  }
  if (count == 1) {
    const int edge = marked[0] ? 0 : marked[1] ? 1 : 2;
    const std::uint32_t p = v[edge];
    const std::uint32_t q = v[(edge + 1) % 3];
    const std::uint32_t r = v[(edge + 2) % 3];
    const std::uint32_t m = points.Midpoint(p, q);
    return {{p, m, r}, {m, q, r}};
  }
  // Two: turn the triangle so that the unmarked edge is (r p); the quadrangle p m1 m2 r is cut
  // along its shorter diagonal.
  const int unmarked = !marked[0] ? 0 : !marked[1] ? 1 : 2;
  const std::uint32_t p = v[(unmarked + 1) % 3];
  const std::uint32_t q = v[(unmarked + 2) % 3];
  const std::uint32_t r = v[unmarked];
  const std::uint32_t m1 = points.Midpoint(p, q);
  const std::uint32_t m2 = points.Midpoint(q, r);
  if (points.Distance(m1, r) < points.Distance(p, m2)) {
    return {{m1, q, m2}, {p, m1, r}, {m1, m2, r}};
  }
  return {{m1, q, m2}, {p, m1, m2}, {p, m2, r}};
}

}  // namespace

std::optional<RefinedMesh> TryRefineMesh(const Mesh& mesh,
                                         const TargetLength& target,
                                         std::size_t max_triangles) {
  RefinedMesh refined;
  refined.mesh.positions_m = mesh.positions_m;
  refined.mesh.normals = mesh.normals;
  refined.mesh.materials = mesh.materials;
  refined.mesh.group_names = mesh.group_names;
  Midpoints points(refined.mesh, target);
  ColoursOfPieces colours(mesh, points);

  struct Piece {
    glm::uvec3 corners;
    std::uint32_t source;
  };
  std::vector<Piece> waiting;
  for (std::size_t i = mesh.triangles.size(); i-- > 0;) {
    waiting.push_back({mesh.triangles[i], static_cast<std::uint32_t>(i)});
  }
  // Depth first, so that the pieces of a source triangle stay together and in order.
  while (!waiting.empty()) {
    const Piece piece = waiting.back();
    waiting.pop_back();
    const glm::uvec3& v = piece.corners;
    const std::array<bool, 3> marked{
        points.TooLong(v[0], v[1]), points.TooLong(v[1], v[2]), points.TooLong(v[2], v[0])};
    if (marked[0] || marked[1] || marked[2]) {
      for (const glm::uvec3& corners : Split(v, marked, points)) {
        waiting.push_back({corners, piece.source});
      }
    } else {
      refined.mesh.triangles.push_back(v);
      refined.mesh.triangle_material.push_back(mesh.triangle_material[piece.source]);
      refined.mesh.triangle_group.push_back(mesh.triangle_group[piece.source]);
      if (TriangleNormal(refined.mesh,
                         static_cast<std::uint32_t>(refined.mesh.triangles.size() - 1)) ==
          glm::vec3(0.0f)) {
        refined.mesh.triangles.pop_back();
        refined.mesh.triangle_material.pop_back();
        refined.mesh.triangle_group.pop_back();
      } else {
        refined.source_triangle.push_back(piece.source);
        if (!mesh.triangle_colours.empty()) {
          refined.mesh.triangle_colours.push_back(colours.Of(v, piece.source));
        }
      }
    }
    if (refined.mesh.triangles.size() + waiting.size() > max_triangles) return std::nullopt;
  }
  return refined;
}

RefinedMesh RefineMesh(const Mesh& mesh, const TargetLength& target, std::size_t max_triangles) {
  std::optional<RefinedMesh> refined = TryRefineMesh(mesh, target, max_triangles);
  if (!refined) {
    throw std::invalid_argument("patch size: the mesh would be cut into more than " +
                                std::to_string(max_triangles) +
                                " patches: expected a larger patch_size_m or growth_per_m");
  }
  return *std::move(refined);
}

}  // namespace pleinair

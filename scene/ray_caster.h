// Ray queries against a mesh, through Embree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/mesh.h"

namespace pleinair {

// The complete result of one ray.
struct RayHit {
  float distance_m = 0.0f;
  std::uint32_t triangle = 0;
  glm::vec2 barycentric{0.0f};       // Weights of corners 1 and 2.
  glm::vec3 position_m{0.0f};        // From the barycentric weights: lies on the triangle.
  glm::vec3 geometric_normal{0.0f};  // Unit, by winding, not turned to the ray.
};

// The short result of one ray among many.
struct FaceHit {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t triangle = kNone;
  bool is_front = false;  // On the side that the winding's normal points to.
  float distance_m = std::numeric_limits<float>::infinity();  // To single precision.
};

// Immutable after construction, safe from any thread, holds no reference to the mesh.
//
// Accuracy  Which side of a triangle's plane a ray starts on is decided in double precision (but
//           for Origin::kOffMesh), so that a ray started by OffsetFromSurface never meets its own
//           surface, however large the triangles. Rays through edges and vertices do not slip
//           through. A ray that starts within a rounding error of an edge may start on the other
//           side of it.
// Not       hit: triangles without area, or with a corner that is not finite or beyond 1.8e18 m. A
//           ray that is not finite, or beyond that, misses. Places that a material cuts out are not
//           hit either.
class RayCaster {
 public:
  // An empty mesh is allowed: every ray misses.
  explicit RayCaster(const Mesh& mesh);
  ~RayCaster();
  RayCaster(RayCaster&&) noexcept;
  RayCaster& operator=(RayCaster&&) noexcept;

  // The nearest hit with distance in (0, max_distance_m); direction must be unit.
  std::optional<RayHit> Intersect(
      const glm::vec3& origin_m,
      const glm::vec3& direction,
      float max_distance_m = std::numeric_limits<float>::infinity()) const;

  // `count` queries at once; faster than one by one where rays are coherent. For equal distances,
  // it may return another hit than the single query.
  // Shape  origins_m, directions, hits: count entries each.
  void Intersect(const glm::vec3* origins_m,
                 const glm::vec3* directions,
                 std::size_t count,
                 std::optional<RayHit>* hits) const;

  // `count` queries at once, with short results: the faster way for rays that are not coherent.
  // Shape  origins_m, directions, hits: count entries each.
  void Intersect(const glm::vec3* origins_m,
                 const glm::vec3* directions,
                 std::size_t count,
                 FaceHit* hits) const;

  // The same where a ray goes no farther than its entry of `hits` says, such as the distance to
  // another mesh. A ray that meets nothing nearer keeps its distance and gets no triangle.
  void IntersectNearer(const glm::vec3* origins_m,
                       const glm::vec3* directions,
                       std::size_t count,
                       FaceHit* hits) const;

  // The same for `count` rays from one point, with short results: faster still. It is fastest for a
  // point that is known to be off the mesh, where single precision decides on triangles' sides.
  // Shape  directions, hits: count entries each.
  enum class Origin : std::uint8_t { kMayBeOnMesh, kOffMesh };
  void IntersectFrom(const glm::vec3& origin_m,
                     Origin where,
                     const glm::vec3* directions,
                     std::size_t count,
                     FaceHit* hits) const;

  // Distance to the nearest point of a triangle, cut-out places included, or `within_m` where that
  // is less. Triangles that are not finite have none.
  float DistanceTo(const glm::vec3& point_m, float within_m) const;

  // Whether there is any hit in (0, max_distance_m).
  bool Occluded(const glm::vec3& origin_m,
                const glm::vec3& direction,
                float max_distance_m = std::numeric_limits<float>::infinity()) const;

  // `count` occlusion queries at once; faster than single queries where rays are coherent. Shape
  // origins_m, directions, occluded: count entries each.
  void Occluded(const glm::vec3* origins_m,
                const glm::vec3* directions,
                std::size_t count,
                bool* occluded) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Returns the start of a ray that leaves a surface at `position_m` to the side of `normal_to_side`,
// such that it neither meets that surface again nor skips a neighbour. The point is moved along the
// normal by the rounding error of a hit point at these coordinates (after pbrt-v4's OffsetRayOrigin
// idea).
glm::vec3 OffsetFromSurface(const glm::vec3& position_m, const glm::vec3& normal_to_side);

}  // namespace pleinair

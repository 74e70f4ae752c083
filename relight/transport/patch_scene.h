// The site's mesh cut into small patches: what light is carried between.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/ray_caster.h"
#include "scene/skyline.h"

namespace pleinair {

struct PatchOptions {
  glm::dvec3 focus_m{0.0};                   // Where light is asked for: patches are finest there.
  std::vector<glm::dvec3> focus_points_m{};  // Several places instead: the nearest counts.
  double patch_size_m = 0.5;                 // Longest edge near the focus.
  double growth_per_m = 0.1;  // Longest edge grows by this for each metre from the focus.
  bool extend_ground = true;  // To the horizon, with the ground's mean albedo, where it ends near.
  // In [0, 1). Above 0 a plane of this albedo, at the mesh's foot, goes to the horizon in place of
  // that: what comes from below the horizon is then estimated from what comes from above it.
  double ground_albedo = 0.0;
  // Triangles that are small beside the longest edge allowed share a patch. False: each is one.
  bool join_small = true;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Which triangles a patch has, where it has several.
struct PatchesOfTriangles {
  std::vector<std::uint32_t> begin;        // Patch p: triangles [begin[p], begin[p + 1]).
  std::vector<std::uint32_t> of_triangle;  // Per triangle: its patch.
  std::vector<float> area_share_until;     // Per triangle: of its patch, it and those before.
  std::vector<glm::vec3> smooth_normal;    // Per triangle, of its front.
  std::vector<float> area_m2;              // Per patch,
  std::vector<glm::vec3> normal;           // of its front.

  bool Empty() const { return begin.empty(); }
  std::size_t Count() const { return begin.empty() ? 0 : begin.size() - 1; }
};

// Light is carried between patches; rays meet triangles. A patch is a triangle of `mesh`, or
// several small ones of one place, direction, group and material. Triangle t has the sides 2 t,
// which its winding's normal points to, and 2 t + 1; patch p has the faces 2 p and 2 p + 1, of its
// triangles' sides. Triangles are cut along their edges only, so that neighbours stay joined.
struct PatchScene {
  static constexpr std::int32_t kSky = -1;

  Mesh mesh;                                   // The cut mesh; groups and materials of the source.
  std::vector<glm::vec3> face_albedo_rgb;      // Per face.
  std::vector<std::uint32_t> source_triangle;  // Per triangle: that of the source mesh; the
                                               // extension's have kExtension.
  static constexpr std::uint32_t kExtension = 0xffffffffu;
  PatchesOfTriangles several;  // Empty where each triangle is a patch.
  bool ground_extended = false;
  bool ground_laid = false;  // By PatchOptions::ground_albedo.
  RayCaster caster{Mesh{}};  // Over `mesh`: a hit's triangle is the patch.
  Skyline skyline;           // What hides the sky beside `mesh`: found by a survey.

  std::size_t SideCount() const { return 2 * mesh.triangles.size(); }
  std::size_t PatchCount() const {
    return several.Empty() ? mesh.triangles.size() : several.Count();
  }
  std::size_t FaceCount() const { return 2 * PatchCount(); }
  // The first of a patch's triangles; they are in a row.
  std::size_t FirstTriangleOf(std::size_t patch) const {
    return several.Empty() ? patch : several.begin[patch];
  }
  struct TriangleRange {
    std::size_t begin;
    std::size_t end;
  };
  TriangleRange TrianglesOf(std::size_t patch) const {
    const std::size_t first = FirstTriangleOf(patch);
    return {first, several.Empty() ? first + 1 : several.begin[patch + 1]};
  }
  std::size_t PatchOf(std::size_t triangle) const {
    return several.Empty() ? triangle : several.of_triangle[triangle];
  }
  bool IsJoined(std::size_t patch) const {
    return !several.Empty() && several.begin[patch + 1] - several.begin[patch] > 1;
  }
  std::uint32_t GroupOf(std::size_t patch) const {
    return mesh.triangle_group[FirstTriangleOf(patch)];
  }
  std::uint32_t MaterialOf(std::size_t patch) const {
    return mesh.triangle_material[FirstTriangleOf(patch)];
  }
  bool IsExtension(std::size_t patch) const {
    return source_triangle[FirstTriangleOf(patch)] == kExtension;
  }
  // The side that a ray along `direction` meets on `hit`, and its face.
  static std::int32_t SideOfHit(const RayHit& hit, const glm::vec3& direction);
  static std::int32_t SideOfHit(const FaceHit& hit) {
    return static_cast<std::int32_t>(2 * hit.triangle + (hit.is_front ? 0 : 1));
  }
  std::int32_t FaceOfSide(std::int32_t side) const {
    if (several.Empty()) return side;
    return static_cast<std::int32_t>(2 * several.of_triangle[static_cast<std::size_t>(side) / 2]) +
           side % 2;
  }
  std::int32_t FaceOfHit(const RayHit& hit, const glm::vec3& direction) const {
    return FaceOfSide(SideOfHit(hit, direction));
  }
  std::int32_t FaceOfHit(const FaceHit& hit) const { return FaceOfSide(SideOfHit(hit)); }
  // Unit normal of a triangle's side; zero for one without area.
  glm::vec3 SideNormal(std::size_t side) const;
  // Unit normal of the surface that the triangle represents: for one among small ones, a mean with
  // those around it.
  glm::vec3 SurfaceNormal(std::size_t side) const;
  // Normal of a face: the mean over its triangles' area.
  glm::vec3 FaceNormal(std::size_t face) const;
  double PatchAreaM2(std::size_t patch) const;
  // Longest edge of a patch's triangle; for a joined patch, the diagonal of a square of its area.
  float LongestEdgeM(std::size_t patch) const;
  // Mean of the triangles' middles, by area.
  glm::vec3 PatchMiddleM(std::size_t patch) const;
  // A point of a patch for one of the unit square, uniform over its area.
  struct Point {
    glm::vec3 position_m;
    std::size_t triangle;
  };
  Point PointOn(std::size_t patch, glm::dvec2 point) const;
};

// Face albedos start as the materials' diffuse albedo.
//
// Throws  std::invalid_argument for options or a mesh that make no sense, naming the field; and
//         when more than 2^21 patches would come out, or as many more triangles than `mesh` has.
PatchScene BuildPatchScene(const Mesh& mesh, const PatchOptions& options);

// Whether no more than `budget` patches would come out of the mesh itself, its ground not extended.
bool FitsPatchBudget(const Mesh& mesh, const PatchOptions& options, std::size_t budget);

}  // namespace pleinair

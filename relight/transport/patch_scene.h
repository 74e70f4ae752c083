// The site's mesh cut into small patches: what light is carried between.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/ray_caster.h"
#include "scene/skyline.h"

namespace pleinair {

struct PatchOptions {
  glm::dvec3 focus_m{0.0};                   // Where light is asked for: patches are finest there.
  std::vector<glm::dvec3> focus_points_m{};  // Several places in its stead: the nearest counts.
  double patch_size_m = 0.5;                 // Longest edge near the focus.
  double growth_per_m = 0.1;  // Longest edge grows by this for each metre from the focus.
  bool extend_ground = true;  // To the horizon, with the ground's mean albedo, where it ends near.
  // In [0, 1). Above 0 a plane of this albedo, at the mesh's foot, goes to the horizon in place of
  // that: what comes from below the horizon is then estimated from what comes from above it.
  double ground_albedo = 0.0;
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Each triangle of `mesh` is a patch with two faces: 2 i is the side its winding's normal points
// to, 2 i + 1 the other. Triangles are cut along their edges only, so that neighbours stay joined.
struct PatchScene {
  static constexpr std::int32_t kSky = -1;

  Mesh mesh;                                   // The cut mesh; groups and materials of the source.
  std::vector<glm::vec3> face_albedo_rgb;      // Per face.
  std::vector<std::uint32_t> source_triangle;  // Per patch: triangle of the source mesh; the
                                               // extension's patches have kExtension.
  static constexpr std::uint32_t kExtension = 0xffffffffu;
  bool ground_extended = false;
  bool ground_laid = false;  // By PatchOptions::ground_albedo.
  RayCaster caster{Mesh{}};  // Over `mesh`: a hit's triangle is the patch.
  Skyline skyline;           // What hides the sky beside `mesh`: found by a survey.

  std::size_t FaceCount() const { return 2 * mesh.triangles.size(); }
  // The face that a ray along `direction` meets on `hit`.
  static std::int32_t FaceOfHit(const RayHit& hit, const glm::vec3& direction);
  static std::int32_t FaceOfHit(const FaceHit& hit) {
    return static_cast<std::int32_t>(2 * hit.triangle + (hit.is_front ? 0 : 1));
  }
  // Unit normal of a face, to its own side.
  glm::vec3 FaceNormal(std::size_t face) const;
  double PatchAreaM2(std::size_t patch) const;
};

// Face albedos start as the materials' diffuse albedo.
//
// Throws  std::invalid_argument for options or a mesh that make no sense, naming the field; and
//         when more than 2^21 patches would come out.
PatchScene BuildPatchScene(const Mesh& mesh, const PatchOptions& options);

// Whether no more than `budget` patches would come out of the mesh itself, its ground not extended.
bool FitsPatchBudget(const Mesh& mesh, const PatchOptions& options, std::size_t budget);

}  // namespace pleinair

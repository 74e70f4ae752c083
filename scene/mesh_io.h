// Mesh files: OBJ (with the Pr roughness extension), glTF, PLY, STL, through assimp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/mesh.h"
#include "scene/part_motion.h"

namespace pleinair {

// Defects that loading repaired or left out. All zero for a clean file.
struct MeshReport {
  std::int64_t degenerate_triangles_removed = 0;  // No area, relative to the mesh's size.
  std::int64_t duplicate_triangles_removed = 0;   // Same three corners, same winding.
  std::int64_t non_finite_triangles_removed = 0;  // A corner is NaN or infinite.
  std::int64_t normals_computed = 0;              // Vertices whose normal was missing or zero.

  // Edges of the repaired mesh, with vertices of equal position merged.
  std::int64_t open_edges = 0;          // One triangle only.
  std::int64_t non_manifold_edges = 0;  // More than two.
  std::int64_t misoriented_edges = 0;   // Two that disagree on which side is outside.

  std::vector<std::string> notes;  // E.g. a texture that was replaced by its mean colour.

  bool IsClosedManifold() const { return open_edges == 0 && non_manifold_edges == 0; }
  std::string Summary() const;  // One line.
};

// A mesh and the report of its loading.
struct LoadedMesh {
  Mesh mesh;
  MeshReport report;
};

// How textures, and the vertex colours of glTF, are used.
enum class MeshColours {
  // As a material's mean: for scenes, where each material has one measured albedo.
  kMaterials,
  // By place: for objects to draw. Each triangle gets a material of its name with the means over
  // it, and by_place where its colour varies.
  kByPlace,
};

// Loads a mesh. n-gons are cut into triangles (concave ones too), corners of equal position and
// normal are welded, node transforms are applied, glTF's Y-up is turned to Z-up. The winding is
// kept.
//
// Groups      an OBJ's `g`, else `o`; a glTF's nodes; otherwise the file's name. Parts of one name
//             are one group.
// Normals     the file's. Missing ones, and those of STL (which has none for shading), are the mean
//             of the triangles around the corner that meet at less than 60 deg.
// Materials   as the sequence format says: Kd, Ks linear; Pr, else Ns (alpha^2 = 2 / (Ns + 2));
//             glTF metallic-roughness. Kd is limited to 0.98; that, textures and what is left out
//             are notes. An OBJ whose material libraries are all missing gets Kd 0.5, noted.
// Textures    by place (PNG, JPEG; u, v within 1e4): with glTF's wrap modes and alphaMode MASK.
//             Triangles without usable coordinates have the texture's mean, noted. For a scene, a
//             texture that cannot be read is left out, noted.
// Animation   left out: nodes have their rest pose.
// Throws      std::runtime_error naming the file and what was expected. Reasons: unreadable, no
//             triangle left or more than 2^24, a material name that the libraries don't define, a
//             file outside the mesh's folder. By place, a texture that cannot be read. Also a
//             coordinate beyond 1e5 m of the origin: float would lose the millimetres, and
//             georeferenced models must be moved to a local origin.
// Process     assimp reads in a child of this process: files that crash it are refused as well.
LoadedMesh LoadMesh(const std::filesystem::path& file,
                    MeshColours colours = MeshColours::kMaterials);

// Triangles that move together, at the beginning of the animation.
struct MeshPart {
  Mesh mesh;
  PartMotion motion;  // In the mesh's axes.
};

// The parts of a mesh file that move separately.
struct LoadedParts {
  std::vector<MeshPart> parts;  // At least one; the part that stands still first, if there is one.
  MeshReport report;            // One report for all parts.
};

// As LoadMesh, with the nodes moved by the first animation of a glTF. Skins and morph targets stay
// at rest, noted. Throws as well for animations that make no sense.
LoadedParts LoadMeshParts(const std::filesystem::path& file, MeshColours colours);

}  // namespace pleinair

#include "scene/mesh_io.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "scene/internal/assimp_import.h"
#include "scene/internal/gltf_motion.h"
#include "scene/internal/mesh_collector.h"
#include "scene/internal/mesh_file_check.h"
#include "scene/internal/obj_materials.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

MeshFormat FormatOf(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (extension == ".obj") return MeshFormat::kObj;
  if (extension == ".gltf" || extension == ".glb") return MeshFormat::kGltf;
  if (extension == ".ply") return MeshFormat::kPly;
  if (extension == ".stl") return MeshFormat::kStl;
  throw std::runtime_error(file.string() + ": expected a .obj, .gltf, .glb, .ply or .stl mesh");
}

std::uint64_t TrianglesOf(const ImportedScene& scene, const ImportedNode& node) {
  std::uint64_t count = 0;
  for (const std::uint32_t mesh : node.meshes) count += scene.meshes[mesh].triangles.size();
  for (const ImportedNode& child : node.children) count += TrianglesOf(scene, child);
  return count;
}

// Before they are built: nodes of a glTF may use one mesh as often as they like, and a triangle
// takes some 200 bytes.
void RequireFewTriangles(const std::filesystem::path& file, const ImportedScene& scene) {
  constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 24U;
  const std::uint64_t count = TrianglesOf(scene, scene.root);
  if (count <= kMostTriangles) return;
  RefuseFile(file,
             std::to_string(count) + " triangles: expected at most " +
                 std::to_string(kMostTriangles) + ", those of repeated meshes counted each time");
}

LoadedParts Load(const std::filesystem::path& file, MeshColours colours, bool moving) {
  const MeshFormat format = FormatOf(file);
  RequireFile(file);
  ObjMaterials obj_materials;
  if (format == MeshFormat::kObj) obj_materials = ReadObjMaterials(file);
  if (format == MeshFormat::kGltf) RequireSoundGltf(file);
  if (format == MeshFormat::kPly) RequireSoundPlyHeader(file);

  const ImportedScene scene = ImportMeshFile(file, format);
  RequireFewTriangles(file, scene);
  GltfMotion motion;
  const bool moves = moving && format == MeshFormat::kGltf && scene.has_animations;
  if (moves) motion = ReadGltfMotion(file);
  MeshCollector collector(file, format, colours, scene, obj_materials);
  collector.Collect(moves ? &motion : nullptr);
  LoadedParts loaded = collector.Finish();
  std::vector<std::string>& notes = loaded.report.notes;
  notes.insert(notes.end(), motion.notes.begin(), motion.notes.end());
  for (const std::string& library : obj_materials.missing_libraries) {
    notes.push_back("material library '" + library + "' not found");
  }
  return loaded;
}

}  // namespace

std::string MeshReport::Summary() const {
  std::string text;
  const auto add = [&](std::int64_t count, const char* what) {
    if (count == 0) return;
    if (!text.empty()) text += ", ";
    text += std::to_string(count) + " " + what;
  };
  add(degenerate_triangles_removed, "triangles without area removed");
  add(duplicate_triangles_removed, "duplicate triangles removed");
  add(non_finite_triangles_removed, "non-finite triangles removed");
  add(normals_computed, "normals computed");
  add(open_edges, "open edges");
  add(non_manifold_edges, "non-manifold edges");
  add(misoriented_edges, "edges with contradictory winding");
  for (const std::string& note : notes) text += (text.empty() ? "" : ", ") + note;
  return text.empty() ? "clean" : text;
}

LoadedMesh LoadMesh(const std::filesystem::path& file, MeshColours colours) {
  LoadedParts loaded = Load(file, colours, false);
  return {std::move(loaded.parts.front().mesh), std::move(loaded.report)};
}

LoadedParts LoadMeshParts(const std::filesystem::path& file, MeshColours colours) {
  return Load(file, colours, true);
}

}  // namespace pleinair

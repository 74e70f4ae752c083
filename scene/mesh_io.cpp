#include "scene/mesh_io.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include "scene/internal/encoded_image.h"
#include "scene/internal/gltf_motion.h"
#include "scene/internal/mesh_collector.h"
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

// Whether an OBJ's numbers begin at `at` with their point: ".5", "-.5".
bool BeginsWithPoint(std::string_view text, std::size_t at) {
  if (text[at] != '.') return false;
  std::size_t before = at;
  if (before > 0 && (text[before - 1] == '-' || text[before - 1] == '+')) --before;
  const auto is_in = [&](std::size_t i, std::string_view characters) {
    return i < text.size() && characters.find(text[i]) != std::string_view::npos;
  };
  return before > 0 && is_in(before - 1, " \t") && is_in(at + 1, "0123456789");
}

// An OBJ's text with a zero before such points on its lines of coordinates (v, vn, vt): assimp
// counts numbers by their first character, and takes ".5" for none.
std::string WithLeadingZeros(std::string_view text) {
  std::string written;
  bool is_of_coordinates = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i == 0 || text[i - 1] == '\n') is_of_coordinates = text[i] == 'v';
    if (is_of_coordinates && BeginsWithPoint(text, i)) written += '0';
    written += text[i];
  }
  return written;
}

// Opens only what lies in the mesh's folder: a mesh from elsewhere must not read the user's files.
class FolderIoSystem : public Assimp::DefaultIOSystem {
 public:
  // `obj` is read WithLeadingZeros; empty: no file is.
  FolderIoSystem(std::filesystem::path folder, const std::filesystem::path& obj)
      : folder_(std::move(folder)), obj_(obj) {
    if (obj_.empty()) return;
    const std::vector<std::byte> bytes = ReadWholeFile(obj_);
    obj_text_ = WithLeadingZeros({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }

  bool Exists(const char* file) const override {
    return IsInside(file, folder_) && DefaultIOSystem::Exists(file);
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (!IsInside(file, folder_)) return nullptr;
    if (obj_ != file) return DefaultIOSystem::Open(file, mode);
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(obj_text_.data()),
                                      obj_text_.size());  // Its reader closes it.
  }

 private:
  std::filesystem::path folder_;
  std::filesystem::path obj_;
  std::string obj_text_;
};

LoadedParts Load(const std::filesystem::path& file, MeshColours colours, bool moving) {
  const MeshFormat format = FormatOf(file);
  RequireFile(file);
  ObjMaterials obj_materials;
  if (format == MeshFormat::kObj) obj_materials = ReadObjMaterials(file);
  if (format == MeshFormat::kGltf) RequireSoundAccessors(file);

  Assimp::Importer importer;
  importer.SetIOHandler(  // The importer owns it.
      new FolderIoSystem(file.parent_path(), format == MeshFormat::kObj ? file : ""));
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw std::runtime_error(file.string() + ": not a readable mesh (" +
                             OneLine(importer.GetErrorString()) + ")");
  }
  GltfMotion motion;
  const bool moves = moving && format == MeshFormat::kGltf && scene->HasAnimations();
  if (moves) motion = ReadGltfMotion(file);
  MeshCollector collector(file, format, colours, *scene, obj_materials);
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

#include "scene/mesh_io.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <assimp/DefaultIOSystem.h>
#include <assimp/GltfMaterial.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "scene/internal/encoded_image.h"
#include "scene/internal/mesh_mending.h"
#include "scene/internal/obj_materials.h"
#include "scene/internal/texture_mean.h"
#include "scene/internal/whole_file.h"

namespace pleinair {
namespace {

// Float keeps 8 mm there; below 1e4 m a millimetre.
constexpr double kMaxCoordinateM = 1e5;

enum class Format { kObj, kGltf, kPly, kStl };

Format FormatOf(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (extension == ".obj") return Format::kObj;
  if (extension == ".gltf" || extension == ".glb") return Format::kGltf;
  if (extension == ".ply") return Format::kPly;
  if (extension == ".stl") return Format::kStl;
  throw std::runtime_error(file.string() + ": expected a .obj, .gltf, .glb, .ply or .stl mesh");
}

// Opens only what lies in the mesh's folder: a mesh from elsewhere must not read the user's files.
class FolderIoSystem : public Assimp::DefaultIOSystem {
 public:
  explicit FolderIoSystem(std::filesystem::path folder) : folder_(std::move(folder)) {}

  bool Exists(const char* file) const override {
    return IsInside(file, folder_) && DefaultIOSystem::Exists(file);
  }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return IsInside(file, folder_) ? DefaultIOSystem::Open(file, mode) : nullptr;
  }

 private:
  std::filesystem::path folder_;
};

glm::dmat4 MatrixOf(const aiMatrix4x4& m) {
  // assimp's members are rows, GLM's arguments columns.
  return {m.a1,
          m.b1,
          m.c1,
          m.d1,
          m.a2,
          m.b2,
          m.c2,
          m.d2,
          m.a3,
          m.b3,
          m.c3,
          m.d3,
          m.a4,
          m.b4,
          m.c4,
          m.d4};
}

glm::dvec3 VectorOf(const aiVector3D& v) { return {v.x, v.y, v.z}; }

// glTF has +Y up and +Z to the front; ours has +Z up, and the front towards -Y.
glm::dmat4 ZUpFromYUp() {
  return {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
}

std::optional<glm::vec3> TextureColour(const aiScene& scene,
                                       const std::filesystem::path& folder,
                                       const std::string& name) {
  if (const aiTexture* texture = scene.GetEmbeddedTexture(name.c_str())) {
    if (texture->mHeight != 0) return std::nullopt;  // Raw texels: in no format that we read.
    return MeanLinearColour(
        std::as_bytes(std::span(reinterpret_cast<const char*>(texture->pcData), texture->mWidth)));
  }
  const std::filesystem::path image = folder / name;
  std::error_code error;
  if (!IsInside(image, folder) || !std::filesystem::is_regular_file(image, error)) {
    return std::nullopt;
  }
  return MeanLinearColour(ReadWholeFile(image));
}

// glTF 2.0, section 3.9.2: a metal has no diffuse part and mirrors its base colour, everything else
// mirrors 4 %.
Material GltfMaterial(const std::filesystem::path& file,
                      const aiScene& scene,
                      const aiMaterial& source,
                      std::vector<std::string>& notes) {
  Material material;
  material.name = source.GetName().C_Str();
  const std::string label = "material '" + material.name + "': ";
  aiColor4D base(1.0f, 1.0f, 1.0f, 1.0f);
  if (source.Get(AI_MATKEY_BASE_COLOR, base) != aiReturn_SUCCESS) {
    source.Get(AI_MATKEY_COLOR_DIFFUSE, base);
  }
  glm::vec3 colour(base.r, base.g, base.b);
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    aiString name;
    if (source.GetTexture(type, 0, &name) != aiReturn_SUCCESS) continue;
    const std::optional<glm::vec3> mean = TextureColour(scene, file.parent_path(), name.C_Str());
    if (mean) {
      colour *= *mean;
      notes.push_back(label + "base colour texture replaced by its mean colour");
    } else {
      notes.push_back(label + "base colour texture cannot be read, left out");
    }
    break;
  }
  float metallic = 0.0f;
  float roughness = 1.0f;
  source.Get(AI_MATKEY_METALLIC_FACTOR, metallic);
  source.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness);
  aiString packed;
  if (source.GetTexture(AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE, &packed) ==
      aiReturn_SUCCESS) {
    notes.push_back(label + "metallic-roughness texture left out, its factors count");
  }
  metallic = std::clamp(metallic, 0.0f, 1.0f);
  constexpr float kDielectricReflectance = 0.04f;
  material.diffuse_albedo = colour * (1.0f - metallic);
  material.specular_reflectance = glm::mix(glm::vec3(kDielectricReflectance), colour, metallic);
  material.roughness = std::clamp(roughness, 0.0f, 1.0f);
  if (LimitMaterial(material)) notes.push_back(label + "reflectance limited to below 1");
  return material;
}

// Whether assimp made the name up for a part that has none.
bool IsMadeUp(const std::string& name) {
  return name.empty() || name == "defaultobject" || name.starts_with("<STL") ||
         name.starts_with("nodes[") || name.starts_with("meshes[");
}

// Collects what an assimp scene holds, materials and groups by name.
class Collector {
 public:
  Collector(const std::filesystem::path& file,
            Format format,
            const aiScene& scene,
            const ObjMaterials& obj_materials)
      : file_(file), format_(format), scene_(scene), obj_materials_(obj_materials) {}

  void Collect(const aiNode& node, const glm::dmat4& parent_from_scene_root) {
    const glm::dmat4 root_from_node = parent_from_scene_root * MatrixOf(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      CollectMesh(node, *scene_.mMeshes[node.mMeshes[i]], root_from_node);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) Collect(*node.mChildren[i], root_from_node);
  }

  LoadedMesh Finish() {
    if (lines_and_points_ > 0) {
      report_.notes.push_back(std::to_string(lines_and_points_) + " points or lines left out");
    }
    MendTriangles(loose_, mesh_, report_);
    if (mesh_.Empty()) {
      throw std::runtime_error(file_.string() + ": no triangle with an area: expected a mesh");
    }
    return {std::move(mesh_), std::move(report_)};
  }

 private:
  void CollectMesh(const aiNode& node, const aiMesh& mesh, const glm::dmat4& root_from_node) {
    const bool has_polygons = std::any_of(mesh.mFaces,
                                          mesh.mFaces + mesh.mNumFaces,
                                          [](const aiFace& face) { return face.mNumIndices >= 3; });
    if (!has_polygons) {
      lines_and_points_ += mesh.mNumFaces;
      return;
    }
    const std::uint32_t material = MaterialIndex(mesh.mMaterialIndex);
    const std::uint32_t group = GroupIndex(node, mesh);
    const glm::dmat3 linear(root_from_node);
    const double determinant = glm::determinant(linear);
    const bool mirrors = determinant < 0.0;
    const bool has_normals = mesh.HasNormals() && format_ != Format::kStl && determinant != 0.0;
    const glm::dmat3 root_from_normal =
        has_normals ? glm::transpose(glm::inverse(linear)) : glm::dmat3(1.0);

    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) {
        ++lines_and_points_;
        continue;
      }
      LooseTriangle triangle;
      triangle.material = material;
      triangle.group = group;
      for (unsigned c = 0; c < 3; ++c) {
        const unsigned index = face.mIndices[c];
        if (index >= mesh.mNumVertices) {
          throw std::runtime_error(file_.string() + ": corner " + std::to_string(index) +
                                   " of a mesh with " + std::to_string(mesh.mNumVertices) +
                                   " vertices");
        }
        LooseCorner& corner = triangle.corners[mirrors ? 2 - c : c];
        corner.position_m =
            glm::dvec3(root_from_node * glm::dvec4(VectorOf(mesh.mVertices[index]), 1.0));
        RequireNear(corner.position_m);
        if (has_normals) {
          corner.normal = glm::vec3(root_from_normal * VectorOf(mesh.mNormals[index]));
        }
      }
      loose_.push_back(triangle);
    }
  }

  void RequireNear(const glm::dvec3& position_m) const {
    for (int axis = 0; axis < 3; ++axis) {
      // Not finite is another matter: such triangles are left out and counted.
      if (std::isfinite(position_m[axis]) && std::abs(position_m[axis]) > kMaxCoordinateM) {
        throw std::runtime_error(
            file_.string() + ": coordinate " + std::to_string(position_m[axis]) +
            " m: expected at most 1e5 m from the origin; move the model to a local origin");
      }
    }
  }

  std::uint32_t MaterialIndex(unsigned source_index) {
    const auto known = material_of_.find(source_index);
    if (known != material_of_.end()) return known->second;
    const auto index = static_cast<std::uint32_t>(mesh_.materials.size());
    mesh_.materials.push_back(MakeMaterial(source_index));
    material_of_.emplace(source_index, index);
    return index;
  }

  Material MakeMaterial(unsigned source_index) {
    Material fallback;
    fallback.name = "default";
    if (source_index >= scene_.mNumMaterials) return fallback;
    const aiMaterial& source = *scene_.mMaterials[source_index];
    const std::string name = source.GetName().C_Str();
    if (format_ == Format::kGltf) {
      // assimp gives primitives without a material a nameless one that it puts last.
      const bool made_up = name.empty() && source_index + 1 == scene_.mNumMaterials;
      return made_up ? fallback : GltfMaterial(file_, scene_, source, report_.notes);
    }
    if (format_ != Format::kObj || name.empty() || name == AI_DEFAULT_MATERIAL_NAME) {
      return fallback;
    }
    const auto defined = obj_materials_.by_name.find(name);
    if (defined != obj_materials_.by_name.end()) return defined->second;
    if (obj_materials_.libraries_read > 0) {
      throw std::runtime_error(file_.string() + ": usemtl '" + name +
                               "': no material library defines it");
    }
    fallback.name = name;
    report_.notes.push_back("material '" + name + "': no material library, taken as grey 0.5");
    return fallback;
  }

  std::uint32_t GroupIndex(const aiNode& node, const aiMesh& mesh) {
    std::string name = node.mName.C_Str();
    if (IsMadeUp(name)) name = mesh.mName.C_Str();
    if (IsMadeUp(name) || format_ == Format::kPly) name = file_.stem().string();
    const auto index = static_cast<std::uint32_t>(mesh_.group_names.size());
    const auto [entry, is_new] = group_of_.emplace(name, index);
    if (is_new) mesh_.group_names.push_back(name);
    return entry->second;
  }

  const std::filesystem::path& file_;
  const Format format_;
  const aiScene& scene_;
  const ObjMaterials& obj_materials_;
  Mesh mesh_;
  MeshReport report_;
  std::vector<LooseTriangle> loose_;
  std::map<unsigned, std::uint32_t> material_of_;
  std::map<std::string, std::uint32_t> group_of_;
  std::int64_t lines_and_points_ = 0;
};

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

LoadedMesh LoadMesh(const std::filesystem::path& file) {
  const Format format = FormatOf(file);
  RequireFile(file);
  ObjMaterials obj_materials;
  if (format == Format::kObj) obj_materials = ReadObjMaterials(file);

  Assimp::Importer importer;
  importer.SetIOHandler(new FolderIoSystem(file.parent_path()));  // The importer owns it.
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw std::runtime_error(file.string() + ": not a readable mesh (" +
                             OneLine(importer.GetErrorString()) + ")");
  }
  Collector collector(file, format, *scene, obj_materials);
  collector.Collect(*scene->mRootNode, format == Format::kGltf ? ZUpFromYUp() : glm::dmat4(1.0));
  LoadedMesh loaded = collector.Finish();
  for (const std::string& library : obj_materials.missing_libraries) {
    loaded.report.notes.push_back("material library '" + library + "' not found");
  }
  loaded.report.notes.insert(
      loaded.report.notes.end(), obj_materials.notes.begin(), obj_materials.notes.end());
  return loaded;
}

}  // namespace pleinair

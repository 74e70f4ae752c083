#include "scene/internal/assimp_import.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <assimp/DefaultIOSystem.h>
#include <assimp/GltfMaterial.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include "scene/internal/encoded_image.h"
#include "scene/internal/isolated_work.h"
#include "scene/internal/obj_materials.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// The reader of OBJ keeps some 40 bytes for each one of the file, with its copies; that of glTF
// reads other files too.
constexpr std::uint64_t kMemoryBytes = std::uint64_t{4} << 30U;
constexpr std::uint64_t kMemoryForEachByte = 64;
// 5 MB of OBJ take a second on a slow machine.
constexpr std::uint64_t kTimeS = 20;
constexpr std::uint64_t kBytesForEachS = std::uint64_t{1} << 20U;

IsolationLimits LimitsFor(std::uint64_t file_bytes) {
  return {kMemoryBytes + kMemoryForEachByte * file_bytes,
          std::chrono::seconds(kTimeS + file_bytes / kBytesForEachS)};
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

glm::vec3 VectorOf(const aiVector3D& v) { return {v.x, v.y, v.z}; }

TextureWrap WrapOf(const aiMaterial& source, const char* key, aiTextureType type) {
  int mode = aiTextureMapMode_Wrap;
  source.Get(key, type, 0, mode);
  if (mode == aiTextureMapMode_Mirror) return TextureWrap::kMirror;
  return mode == aiTextureMapMode_Clamp ? TextureWrap::kClamp : TextureWrap::kRepeat;
}

// assimp turns glTF's transform, around the upper left corner and with v down, into one around the
// middle and with v up, by another offset: here that is undone.
void ReadTransform(const aiMaterial& source, aiTextureType type, ImportedTexture& texture) {
  aiUVTransform transform;
  if (source.Get(AI_MATKEY_UVTRANSFORM(type, 0), transform) != aiReturn_SUCCESS) return;
  const glm::dvec2 scale(transform.mScaling.x, transform.mScaling.y);
  const double rotation_rad = -double{transform.mRotation};
  const double c = std::cos(rotation_rad);
  const double s = std::sin(rotation_rad);
  texture.uv_scale = scale;
  texture.uv_rotation_rad = rotation_rad;
  texture.uv_offset = {transform.mTranslation.x - 0.5 * scale.x * (1.0 - c + s),
                       0.5 * scale.y * (s + c - 1.0) + 1.0 - scale.y - transform.mTranslation.y};
}

// Finds the texture. False: the material has none of this type.
bool FindTexture(const aiScene& scene,
                 const aiMaterial& source,
                 aiTextureType type,
                 unsigned number,
                 ImportedTexture& texture) {
  aiString name;
  if (source.GetTexture(type, number, &name) != aiReturn_SUCCESS) return false;
  texture.name = name.C_Str();
  texture.embedded = scene.GetEmbeddedTextureAndIndex(name.C_Str()).second;
  return true;
}

ImportedTexture BaseTexture(const aiScene& scene, const aiMaterial& source) {
  ImportedTexture texture;
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    if (!FindTexture(scene, source, type, 0, texture)) continue;
    texture.wraps = {WrapOf(source, _AI_MATKEY_MAPPINGMODE_U_BASE, type),
                     WrapOf(source, _AI_MATKEY_MAPPINGMODE_V_BASE, type)};
    int set = 0;
    source.Get(AI_MATKEY_UVWSRC(type, 0), set);
    texture.set = static_cast<std::uint32_t>(std::max(set, 0));
    ReadTransform(source, type, texture);
    break;
  }
  return texture;
}

ImportedMaterial MaterialOf(const aiScene& scene, const aiMaterial& source) {
  ImportedMaterial material;
  material.name = source.GetName().C_Str();
  aiString mode;
  if (source.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) == aiReturn_SUCCESS) {
    material.blends = std::string_view(mode.C_Str()) == "BLEND";
    if (std::string_view(mode.C_Str()) == "MASK") {
      constexpr float kDefaultCutoff = 0.5f;
      material.alpha_cutoff = kDefaultCutoff;
      source.Get(AI_MATKEY_GLTF_ALPHACUTOFF, material.alpha_cutoff);
      material.alpha_cutoff = std::max(material.alpha_cutoff, 0.0f);
    }
  }
  aiColor4D base(1.0f, 1.0f, 1.0f, 1.0f);
  if (source.Get(AI_MATKEY_BASE_COLOR, base) != aiReturn_SUCCESS) {
    source.Get(AI_MATKEY_COLOR_DIFFUSE, base);
  }
  material.base_colour = glm::vec4(base.r, base.g, base.b, base.a);
  source.Get(AI_MATKEY_METALLIC_FACTOR, material.metallic);
  source.Get(AI_MATKEY_ROUGHNESS_FACTOR, material.roughness);
  material.base_texture = BaseTexture(scene, source);
  FindTexture(scene,
              source,
              AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE,
              material.metallic_roughness_texture);
  aiColor3D emitted(0.0f, 0.0f, 0.0f);
  source.Get(AI_MATKEY_COLOR_EMISSIVE, emitted);
  material.emits = !emitted.IsBlack();
  aiString normals;
  material.has_normal_texture =
      source.GetTexture(aiTextureType_NORMALS, 0, &normals) == aiReturn_SUCCESS;
  return material;
}

ImportedMesh MeshOf(const aiMesh& source) {
  ImportedMesh mesh;
  mesh.name = source.mName.C_Str();
  mesh.material = source.mMaterialIndex;
  mesh.has_skin_or_morphs = source.HasBones() || source.mNumAnimMeshes > 0;
  const std::span positions(source.mVertices, source.mNumVertices);
  std::transform(positions.begin(), positions.end(), std::back_inserter(mesh.positions), VectorOf);
  if (source.HasNormals()) {
    const std::span normals(source.mNormals, source.mNumVertices);
    std::transform(normals.begin(), normals.end(), std::back_inserter(mesh.normals), VectorOf);
  }
  if (source.HasVertexColors(0)) {
    for (const aiColor4D& colour : std::span(source.mColors[0], source.mNumVertices)) {
      mesh.colours.emplace_back(colour.r, colour.g, colour.b, colour.a);
    }
  }
  for (const aiVector3D* set : source.mTextureCoords) {
    std::vector<glm::vec2>& texture_uv = mesh.texture_uv.emplace_back();
    if (set == nullptr) continue;
    for (const aiVector3D& uv : std::span(set, source.mNumVertices)) {
      texture_uv.emplace_back(uv.x, uv.y);
    }
  }
  for (const aiFace& face : std::span(source.mFaces, source.mNumFaces)) {
    if (face.mNumIndices == 3) {
      mesh.triangles.emplace_back(face.mIndices[0], face.mIndices[1], face.mIndices[2]);
    } else {
      ++mesh.points_and_lines;
    }
  }
  return mesh;
}

ImportedNode NodeOf(const aiNode& source) {
  ImportedNode node;
  node.name = source.mName.C_Str();
  node.parent_from_node = MatrixOf(source.mTransformation);
  node.meshes.assign(source.mMeshes, source.mMeshes + source.mNumMeshes);
  for (const aiNode* child : std::span(source.mChildren, source.mNumChildren)) {
    node.children.push_back(NodeOf(*child));
  }
  return node;
}

ImportedScene SceneOf(const aiScene& source) {
  ImportedScene scene;
  scene.root = NodeOf(*source.mRootNode);
  for (const aiMesh* mesh : std::span(source.mMeshes, source.mNumMeshes)) {
    scene.meshes.push_back(MeshOf(*mesh));
  }
  for (const aiMaterial* material : std::span(source.mMaterials, source.mNumMaterials)) {
    scene.materials.push_back(MaterialOf(source, *material));
  }
  for (const aiTexture* picture : std::span(source.mTextures, source.mNumTextures)) {
    std::vector<std::byte>& bytes = scene.pictures.emplace_back();
    if (picture->mHeight != 0) continue;  // Raw texels: in no format that we read.
    bytes.resize(picture->mWidth);
    std::memcpy(bytes.data(), picture->pcData, bytes.size());
  }
  scene.has_animations = source.HasAnimations();
  return scene;
}

ImportedScene Import(const std::filesystem::path& file, MeshFormat format) {
  Assimp::Importer importer;
  importer.SetIOHandler(  // The importer owns it.
      new FolderIoSystem(file.parent_path(), format == MeshFormat::kObj ? file : ""));
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    const std::string reason = importer.GetErrorString();
    // Of a file of a known kind whose content it does not recognise, as where it is cut off.
    const bool is_unknown = reason.find("No suitable reader") != std::string::npos;
    throw std::runtime_error(is_unknown ? "damaged, or it ends early" : reason);
  }
  return SceneOf(*scene);
}

}  // namespace

ImportedScene ImportMeshFile(const std::filesystem::path& file, MeshFormat format) {
  try {
    return SceneFromBytes(RunIsolated([&] { return BytesOf(Import(file, format)); },
                                      LimitsFor(std::filesystem::file_size(file))));
  } catch (const std::exception& error) {
    RefuseFile(file, "not a readable mesh (" + OneLine(error.what()) + ")");
  }
}

}  // namespace pleinair

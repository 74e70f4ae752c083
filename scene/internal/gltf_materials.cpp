#include "scene/internal/gltf_materials.h"

#include <algorithm>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>

#include "scene/internal/obj_materials.h"
#include "scene/internal/whole_file.h"

namespace pleinair {
namespace {

std::optional<Texture> ReadTexture(const aiScene& scene,
                                   const std::filesystem::path& folder,
                                   const std::string& name,
                                   TextureScale scale) {
  if (const aiTexture* texture = scene.GetEmbeddedTexture(name.c_str())) {
    if (texture->mHeight != 0) return std::nullopt;  // Raw texels: in no format that we read.
    return Texture::Decode(
        std::as_bytes(std::span(reinterpret_cast<const char*>(texture->pcData), texture->mWidth)),
        scale);
  }
  const std::filesystem::path image = folder / name;
  std::error_code error;
  if (!IsInside(image, folder) || !std::filesystem::is_regular_file(image, error)) {
    return std::nullopt;
  }
  return Texture::Decode(ReadWholeFile(image), scale);
}

void ReadBaseColour(const std::filesystem::path& file,
                    const aiScene& scene,
                    const aiMaterial& source,
                    const std::string& label,
                    TexturedMaterial& material,
                    std::vector<std::string>& notes) {
  aiColor4D base(1.0f, 1.0f, 1.0f, 1.0f);
  if (source.Get(AI_MATKEY_BASE_COLOR, base) != aiReturn_SUCCESS) {
    source.Get(AI_MATKEY_COLOR_DIFFUSE, base);
  }
  material.base_colour = glm::vec3(base.r, base.g, base.b);
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    aiString name;
    if (source.GetTexture(type, 0, &name) != aiReturn_SUCCESS) continue;
    std::optional<Texture> texture =
        ReadTexture(scene, file.parent_path(), name.C_Str(), TextureScale::kSrgb);
    if (texture) {
      material.texture = std::make_shared<const Texture>(std::move(*texture));
      int set = 0;
      source.Get(AI_MATKEY_UVWSRC(type, 0), set);
      material.texture_set = static_cast<unsigned>(std::max(set, 0));
      aiUVTransform transform;
      if (source.Get(AI_MATKEY_UVTRANSFORM(type, 0), transform) == aiReturn_SUCCESS) {
        notes.push_back(label + "transform of the texture's coordinates left out");
      }
    } else {
      notes.push_back(label + "base colour texture cannot be read, left out");
    }
    break;
  }
}

void NoteWhatIsLeftOut(const aiMaterial& source,
                       const std::string& label,
                       std::vector<std::string>& notes) {
  aiString alpha_mode;
  if (source.Get(AI_MATKEY_GLTF_ALPHAMODE, alpha_mode) == aiReturn_SUCCESS &&
      std::string(alpha_mode.C_Str()) != "OPAQUE") {
    notes.push_back(label + "alphaMode " + alpha_mode.C_Str() + " left out, taken for opaque");
  }
  aiColor3D emitted(0.0f, 0.0f, 0.0f);
  source.Get(AI_MATKEY_COLOR_EMISSIVE, emitted);
  if (!emitted.IsBlack()) notes.push_back(label + "emitted light left out");
  aiString normals;
  if (source.GetTexture(aiTextureType_NORMALS, 0, &normals) == aiReturn_SUCCESS) {
    notes.push_back(label + "normal texture left out");
  }
}

}  // namespace

TexturedMaterial GltfMaterial(const std::filesystem::path& file,
                              const aiScene& scene,
                              const aiMaterial& source,
                              std::vector<std::string>& notes) {
  constexpr float kDielectricReflectance = 0.04f;
  TexturedMaterial material;
  material.name = source.GetName().C_Str();
  const std::string label = "material '" + material.name + "': ";
  ReadBaseColour(file, scene, source, label, material, notes);
  float metallic = 0.0f;
  float roughness = 1.0f;
  source.Get(AI_MATKEY_METALLIC_FACTOR, metallic);
  source.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness);
  aiString packed;
  if (source.GetTexture(AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE, &packed) ==
      aiReturn_SUCCESS) {
    const std::optional<Texture> texture =
        ReadTexture(scene, file.parent_path(), packed.C_Str(), TextureScale::kLinear);
    if (texture) {
      roughness *= texture->Mean().g;
      metallic *= texture->Mean().b;
      notes.push_back(label + "metallic-roughness texture replaced by its means");
    } else {
      notes.push_back(label + "metallic-roughness texture cannot be read, its factors count");
    }
  }
  material.metallic = std::clamp(metallic, 0.0f, 1.0f);
  material.roughness = std::clamp(roughness, 0.0f, 1.0f);
  material.dielectric_reflectance = glm::vec3(kDielectricReflectance);
  NoteWhatIsLeftOut(source, label, notes);
  return material;
}

}  // namespace pleinair

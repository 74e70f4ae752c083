#include "scene/internal/gltf_materials.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>

#include "scene/internal/obj_materials.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// Empty where it cannot be read.
std::vector<std::byte> EncodedImage(const aiScene& scene,
                                    const std::filesystem::path& folder,
                                    const std::string& name) {
  if (const aiTexture* texture = scene.GetEmbeddedTexture(name.c_str())) {
    if (texture->mHeight != 0) return {};  // Raw texels: in no format that we read.
    const auto bytes =
        std::as_bytes(std::span(reinterpret_cast<const char*>(texture->pcData), texture->mWidth));
    return {bytes.begin(), bytes.end()};
  }
  const std::filesystem::path image = folder / name;
  std::error_code error;
  if (!IsInside(image, folder) || !std::filesystem::is_regular_file(image, error) ||
      std::filesystem::file_size(image, error) == 0) {
    return {};
  }
  return ReadWholeFile(image);
}

TextureWrap WrapOf(const aiMaterial& source, const char* key, aiTextureType type) {
  int mode = aiTextureMapMode_Wrap;
  source.Get(key, type, 0, mode);
  if (mode == aiTextureMapMode_Mirror) return TextureWrap::kMirror;
  return mode == aiTextureMapMode_Clamp ? TextureWrap::kClamp : TextureWrap::kRepeat;
}

// assimp turns glTF's transform, around the upper left corner and with v down, into one around the
// middle and with v up, by another offset: here that is undone.
void ReadTransform(const aiMaterial& source, aiTextureType type, SourceMaterial& material) {
  aiUVTransform transform;
  if (source.Get(AI_MATKEY_UVTRANSFORM(type, 0), transform) != aiReturn_SUCCESS) return;
  const glm::dvec2 scale(transform.mScaling.x, transform.mScaling.y);
  const double rotation_rad = -double{transform.mRotation};
  const double c = std::cos(rotation_rad);
  const double s = std::sin(rotation_rad);
  material.uv_scale = scale;
  material.uv_rotation_rad = rotation_rad;
  material.uv_offset = {transform.mTranslation.x - 0.5 * scale.x * (1.0 - c + s),
                        0.5 * scale.y * (s + c - 1.0) + 1.0 - scale.y - transform.mTranslation.y};
}

void ReadAlpha(const aiMaterial& source, SourceMaterial& material) {
  aiString mode;
  if (source.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) != aiReturn_SUCCESS ||
      std::string(mode.C_Str()) != "MASK") {
    return;
  }
  constexpr float kDefaultCutoff = 0.5f;
  material.alpha_cutoff = kDefaultCutoff;
  source.Get(AI_MATKEY_GLTF_ALPHACUTOFF, material.alpha_cutoff);
  material.alpha_cutoff = std::max(material.alpha_cutoff, 0.0f);
}

void ReadBaseColour(const std::filesystem::path& file,
                    const aiScene& scene,
                    const aiMaterial& source,
                    SourceMaterial& material,
                    TexturesByName& textures) {
  aiColor4D base(1.0f, 1.0f, 1.0f, 1.0f);
  if (source.Get(AI_MATKEY_BASE_COLOR, base) != aiReturn_SUCCESS) {
    source.Get(AI_MATKEY_COLOR_DIFFUSE, base);
  }
  material.base_colour = glm::vec3(base.r, base.g, base.b);
  material.base_alpha = base.a;
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
    aiString name;
    if (source.GetTexture(type, 0, &name) != aiReturn_SUCCESS) continue;
    const bool with_alpha = material.alpha_cutoff > 0.0f;
    const auto [entry, is_new] = textures.try_emplace({name.C_Str(), with_alpha});
    if (is_new) {
      entry->second =
          DecodeTexture(EncodedImage(scene, file.parent_path(), name.C_Str()), with_alpha);
    }
    if (!entry->second) {
      material.unreadable_texture = name.C_Str();
      break;
    }
    material.texture = entry->second;
    material.wraps = {WrapOf(source, _AI_MATKEY_MAPPINGMODE_U_BASE, type),
                      WrapOf(source, _AI_MATKEY_MAPPINGMODE_V_BASE, type)};
    int set = 0;
    source.Get(AI_MATKEY_UVWSRC(type, 0), set);
    material.texture_set = static_cast<unsigned>(std::max(set, 0));
    ReadTransform(source, type, material);
    break;
  }
}

void NoteWhatIsLeftOut(const aiMaterial& source,
                       const std::string& label,
                       std::vector<std::string>& notes) {
  aiString alpha_mode;
  if (source.Get(AI_MATKEY_GLTF_ALPHAMODE, alpha_mode) == aiReturn_SUCCESS &&
      std::string(alpha_mode.C_Str()) == "BLEND") {
    notes.push_back(label + "alphaMode BLEND left out, treated as opaque");
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

SourceMaterial GltfMaterial(const std::filesystem::path& file,
                            const aiScene& scene,
                            const aiMaterial& source,
                            TexturesByName& textures,
                            std::vector<std::string>& notes) {
  constexpr float kDielectricReflectance = 0.04f;
  SourceMaterial material;
  material.name = source.GetName().C_Str();
  const std::string label = "material '" + material.name + "': ";
  ReadAlpha(source, material);
  ReadBaseColour(file, scene, source, material, textures);
  float metallic = 0.0f;
  float roughness = 1.0f;
  source.Get(AI_MATKEY_METALLIC_FACTOR, metallic);
  source.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness);
  aiString packed;
  if (source.GetTexture(AI_MATKEY_GLTF_PBRMETALLICROUGHNESS_METALLICROUGHNESS_TEXTURE, &packed) ==
      aiReturn_SUCCESS) {
    const std::optional<glm::vec3> mean =
        MeanOfLinearImage(EncodedImage(scene, file.parent_path(), packed.C_Str()));
    if (mean) {
      roughness *= mean->g;
      metallic *= mean->b;
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

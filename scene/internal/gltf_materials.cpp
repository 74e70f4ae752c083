#include "scene/internal/gltf_materials.h"

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>

#include "scene/internal/obj_materials.h"
#include "scene/whole_file.h"

namespace pleinair {
namespace {

// Empty where it cannot be read.
std::vector<std::byte> EncodedImage(const ImportedScene& scene,
                                    const std::filesystem::path& folder,
                                    const ImportedTexture& texture) {
  if (texture.embedded >= 0) {
    const auto index = static_cast<std::size_t>(texture.embedded);
    return index < scene.pictures.size() ? scene.pictures[index] : std::vector<std::byte>{};
  }
  const std::filesystem::path image = folder / texture.name;
  std::error_code error;
  if (!IsInside(image, folder) || !std::filesystem::is_regular_file(image, error) ||
      std::filesystem::file_size(image, error) == 0) {
    return {};
  }
  return ReadWholeFile(image);
}

void ReadBaseTexture(const std::filesystem::path& file,
                     const ImportedScene& scene,
                     const ImportedTexture& texture,
                     SourceMaterial& material,
                     TexturesByName& textures) {
  if (texture.name.empty()) return;
  const bool with_alpha = material.alpha_cutoff > 0.0f;
  const auto [entry, is_new] = textures.try_emplace({texture.name, with_alpha});
  if (is_new) {
    entry->second = DecodeTexture(EncodedImage(scene, file.parent_path(), texture), with_alpha);
  }
  if (!entry->second) {
    material.unreadable_texture = texture.name;
    return;
  }
  material.texture = entry->second;
  material.wraps = texture.wraps;
  material.texture_set = texture.set;
  material.uv_scale = texture.uv_scale;
  material.uv_rotation_rad = texture.uv_rotation_rad;
  material.uv_offset = texture.uv_offset;
}

}  // namespace

SourceMaterial GltfMaterial(const std::filesystem::path& file,
                            const ImportedScene& scene,
                            const ImportedMaterial& source,
                            TexturesByName& textures,
                            std::vector<std::string>& notes) {
  constexpr float kDielectricReflectance = 0.04f;
  SourceMaterial material;
  material.name = source.name;
  const std::string label = "material '" + material.name + "': ";
  material.alpha_cutoff = source.alpha_cutoff;
  material.base_colour = glm::vec3(source.base_colour);
  material.base_alpha = source.base_colour.a;
  ReadBaseTexture(file, scene, source.base_texture, material, textures);
  float metallic = source.metallic;
  float roughness = source.roughness;
  if (!source.metallic_roughness_texture.name.empty()) {
    const std::optional<glm::vec3> mean = MeanOfLinearImage(
        EncodedImage(scene, file.parent_path(), source.metallic_roughness_texture));
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
  if (source.blends) notes.push_back(label + "alphaMode BLEND left out, treated as opaque");
  if (source.emits) notes.push_back(label + "emitted light left out");
  if (source.has_normal_texture) notes.push_back(label + "normal texture left out");
  return material;
}

}  // namespace pleinair

// glTF's metallic-roughness materials.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/internal/imported_scene.h"
#include "scene/internal/source_material.h"
#include "scene/internal/texture_decoding.h"

namespace pleinair {

// glTF 2.0, section 3.9.2 and appendix B: diffuse albedo (1 - metallic) colour; reflectance at
// normal incidence 4 %, for a metal its colour; GGX's alpha roughness^2. The metallic-roughness
// texture counts with its means. What is left out is a note. `textures` are those of the file.
SourceMaterial GltfMaterial(const std::filesystem::path& file,
                            const ImportedScene& scene,
                            const ImportedMaterial& source,
                            TexturesByName& textures,
                            std::vector<std::string>& notes);

}  // namespace pleinair

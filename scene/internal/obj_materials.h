// The material libraries that an OBJ file names. Read here and not by assimp, which does not
// distinguish a missing key from a default, nor an undefined name from a defined one, and has its
// own defaults.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "scene/internal/source_material.h"
#include "scene/internal/texture_decoding.h"

namespace pleinair {

struct ObjMaterials {
  std::map<std::string, SourceMaterial> by_name;
  TexturesByName textures;
  std::vector<std::string> libraries;  // That were read.
  std::vector<std::string> missing_libraries;
};

// Reads what the `mtllib` lines of `obj` name. Throws std::runtime_error with file, line and what
// was expected for a malformed value, or a library outside the OBJ's folder; a library that doesn't
// exist is listed.
ObjMaterials ReadObjMaterials(const std::filesystem::path& obj);

// Whether `file` lies in `folder` or below, by name.
bool IsInside(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace pleinair

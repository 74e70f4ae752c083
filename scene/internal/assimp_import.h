// Mesh files as assimp reads them.
#pragma once

#include <filesystem>

#include "scene/internal/imported_scene.h"

namespace pleinair {

enum class MeshFormat { kObj, kGltf, kPly, kStl };

// Polygons are cut into triangles.
//
// It runs in a process of its own, with limits of time and memory by the file's size. assimp 5.2
// trusts what it reads: wrong counts, corners or nesting make it crash, hang or fill the memory in
// every one of these formats. A complete check before it would have to repeat all assumptions of
// its readers. RequireSoundMeshFile checks only for files that would take them long.
//
// Throws  std::runtime_error, one line with the file and what was expected.
ImportedScene ImportMeshFile(const std::filesystem::path& file, MeshFormat format);

}  // namespace pleinair

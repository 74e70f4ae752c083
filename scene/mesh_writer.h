// Meshes as OBJ files.
#pragma once

#include <filesystem>

#include "scene/mesh.h"

namespace pleinair {

// Writes `file` (.obj) and, beside it, its material library of the same name (.mtl), each
// completely or not at all. LoadMesh then returns the same triangles, groups, normals and
// materials; textures are left out. Blanks in names become underscores, as OBJ has no such names.
// Throws std::runtime_error naming the file; std::invalid_argument for an empty mesh.
void WriteObj(const Mesh& mesh, const std::filesystem::path& file);

}  // namespace pleinair

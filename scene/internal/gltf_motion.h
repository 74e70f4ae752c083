// The nodes of a glTF file, and their motion by its first animation. They are read here and not by
// assimp, which treats every track as LINEAR. tinygltf 2.7 was tried. It accepts a translation of
// two numbers, nodes and buffer views that do not exist, and buffers outside the file's folder, all
// without an error. So every check here would still be needed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/part_motion.h"

namespace pleinair {

struct GltfMotion {
  std::vector<MovingNode> nodes;           // In the file's order.
  std::vector<std::vector<int>> children;  // Per node, into nodes.
  std::vector<int> roots;                  // Root nodes of the file's scene.
  double duration_s = 0.0;                 // Time of the last key; 0: nothing moves.
  std::vector<std::string> notes;
};

// Checks before assimp reads the file. Throws as ReadGltfMotion for JSON nested deeper than 64 and
// for sparse accessors without indices or values. Also for nodes that are not trees (section 3.5.2:
// each node has one parent at most) of kMostNodeLevels or fewer. Does not throw for a file that is
// no glTF.
void RequireSoundGltf(const std::filesystem::path& file);

// Reads a .gltf or .glb file that assimp has read. Throws std::runtime_error, one line with the
// file, the key and what was expected, for nodes and animations that make no sense, sparse
// accessors, or buffers outside the file's folder.
GltfMotion ReadGltfMotion(const std::filesystem::path& file);

}  // namespace pleinair

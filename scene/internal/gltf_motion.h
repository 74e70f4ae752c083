// The nodes of a glTF file and how its first animation moves them. Read here and not taken from
// assimp, which takes every track for a LINEAR one. tinygltf 2.7 was tried: it accepts a
// translation of two numbers, nodes and buffer views that do not exist, and buffers outside the
// file's folder, all without an error, so that every check here would stay.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scene/part_motion.h"

namespace pleinair {

struct GltfMotion {
  std::vector<MovingNode> nodes;           // In the file's order.
  std::vector<std::vector<int>> children;  // Per node, into nodes.
  std::vector<int> roots;                  // Of the file's scene.
  double duration_s = 0.0;                 // Of the last key; 0: nothing moves.
  std::vector<std::string> notes;
};

// What is checked before assimp reads the file: throws as ReadGltfMotion for JSON nested deeper
// than 64, sparse accessors without indices or values, and nodes that are not trees (section 3.5.2:
// each node has one parent at most) of kMostNodeLevels or fewer. Does not throw for a file that is
// no glTF.
void RequireSoundGltf(const std::filesystem::path& file);

// Reads a .gltf or .glb file that assimp has read. Throws std::runtime_error, one line with the
// file, the key and what was expected, for nodes and animations that make no sense, sparse
// accessors, or buffers outside the file's folder.
GltfMotion ReadGltfMotion(const std::filesystem::path& file);

}  // namespace pleinair

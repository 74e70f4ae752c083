// The content of a mesh file, as plain data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "scene/texture.h"

namespace pleinair {

// The place of a picture: empty where there is none.
struct ImportedTexture {
  std::string name;  // A file, or the picture with that index in the scene.
  std::int32_t embedded = -1;
  TextureWraps wraps;
  std::uint32_t set = 0;  // Which of a vertex' texture coordinates.
  // As in SourceMaterial.
  glm::dvec2 uv_scale{1.0};
  double uv_rotation_rad = 0.0;
  glm::dvec2 uv_offset{0.0};
};

// glTF's metallic-roughness material; of the other formats the name alone.
struct ImportedMaterial {
  std::string name;
  glm::vec4 base_colour{1.0f};
  float alpha_cutoff = 0.0f;  // 0: not alphaMode MASK.
  float metallic = 0.0f;
  float roughness = 1.0f;
  ImportedTexture base_texture;
  ImportedTexture metallic_roughness_texture;
  bool blends = false;  // alphaMode BLEND
  bool emits = false;
  bool has_normal_texture = false;
};

struct ImportedMesh {
  std::string name;
  std::uint32_t material = 0;
  bool has_skin_or_morphs = false;
  std::uint64_t points_and_lines = 0;  // Faces without three corners.
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;                  // As many, or none.
  std::vector<glm::vec4> colours;                  // The first set; one for each vertex, or none.
  std::vector<std::vector<glm::vec2>> texture_uv;  // By set; v goes up. Each as many, or none.
  std::vector<glm::uvec3> triangles;
};

struct ImportedNode {
  std::string name;
  glm::dmat4 parent_from_node{1.0};
  std::vector<std::uint32_t> meshes;
  std::vector<ImportedNode> children;
};

struct ImportedScene {
  ImportedNode root;
  std::vector<ImportedMesh> meshes;
  std::vector<ImportedMaterial> materials;
  std::vector<std::vector<std::byte>> pictures;  // Image files within the scene's.
  bool has_animations = false;
};

// Deeper trees of nodes are refused: what walks them is recursive.
inline constexpr int kMostNodeLevels = 256;

// To bytes and back, between processes of one program. From bytes that may be anything: throws
// std::runtime_error unless they are a scene whose lists are as long as stated above and whose
// indices of meshes and vertices exist.
std::string BytesOf(const ImportedScene& scene);
ImportedScene SceneFromBytes(std::string_view bytes);

}  // namespace pleinair

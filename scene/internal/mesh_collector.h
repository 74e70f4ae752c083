// Collects the content of an imported scene by parts, with materials and groups by name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "scene/internal/assimp_import.h"
#include "scene/internal/gltf_motion.h"
#include "scene/internal/material_list.h"
#include "scene/internal/mesh_repair.h"
#include "scene/internal/obj_materials.h"
#include "scene/internal/source_material.h"
#include "scene/internal/texture_decoding.h"
#include "scene/mesh_io.h"

namespace pleinair {

class MeshCollector {
 public:
  // All outlive this.
  MeshCollector(const std::filesystem::path& file,
                MeshFormat format,
                MeshColours colours,
                const ImportedScene& scene,
                const ObjMaterials& obj_materials);

  // `motion` of the same file, or null: everything stands still. Throws std::runtime_error, one
  // line with the file and what was expected.
  void Collect(const GltfMotion* motion);

  // Call once.
  LoadedParts Finish();

 private:
  struct Part {
    std::vector<LooseTriangle> triangles;  // Their material is one of sources_.
    PartMotion motion;
  };
  // Where the walk is in the tree of nodes.
  struct Place {
    glm::dmat4 root_from_node{1.0};
    std::size_t part = 0;
    std::vector<MovingNode> chain;  // To here; empty where nothing can move.
  };

  void CollectNode(const ImportedNode& node, int gltf_node, Place place, const GltfMotion* motion);
  void CollectMesh(const ImportedNode& node, const ImportedMesh& mesh, const Place& place);
  void RequireNear(const glm::dvec3& position_m) const;
  std::uint32_t SourceIndex(std::uint32_t imported);
  SourceMaterial MakeMaterial(std::uint32_t imported);
  void NoteWhatIsLeftOut(const SourceMaterial& material);
  std::uint32_t GroupIndex(const ImportedNode& node, const ImportedMesh& mesh);
  void SettleByPlace(std::vector<LooseTriangle>& triangles);
  void SettleByMaterial(std::vector<LooseTriangle>& triangles);

  const std::filesystem::path& file_;
  const MeshFormat format_;
  const MeshColours colours_;
  const ImportedScene& scene_;
  const ObjMaterials& obj_materials_;
  std::vector<Part> parts_;
  std::vector<std::shared_ptr<const SourceMaterial>> sources_;
  TexturesByName textures_;
  MaterialList materials_;
  std::vector<std::string> group_names_;
  MeshReport report_;
  std::map<std::uint32_t, std::uint32_t> source_of_;
  std::map<std::string, std::uint32_t> group_of_;
  std::int64_t lines_and_points_ = 0;
  std::int64_t skins_and_morphs_ = 0;
  std::int64_t unplaced_triangles_ = 0;
};

}  // namespace pleinair

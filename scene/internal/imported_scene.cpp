#include "scene/internal/imported_scene.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <type_traits>

namespace pleinair {
namespace {

[[noreturn]] void Refuse(const char* why) {
  throw std::runtime_error(std::string("its reader gave ") + why);
}

// The two archives have the same functions, so that each type is visited by one function both ways.
class Writer {
 public:
  static constexpr bool kReads = false;

  void Raw(const void* data, std::size_t bytes) {
    bytes_.append(static_cast<const char*>(data), bytes);
  }
  std::size_t Count(std::size_t count, std::size_t) {
    Raw(&count, sizeof(count));
    return count;
  }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Reader {
 public:
  static constexpr bool kReads = true;

  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  void Raw(void* data, std::size_t bytes) {
    if (bytes > bytes_.size()) Refuse("too few bytes");
    if (bytes > 0) std::memcpy(data, bytes_.data(), bytes);
    bytes_.remove_prefix(bytes);
  }
  // Reads the number of entries of at least `least_bytes` each. It is checked before memory is
  // allocated.
  std::size_t Count(std::size_t, std::size_t least_bytes) {
    std::size_t count = 0;
    Raw(&count, sizeof(count));
    if (count > bytes_.size() / least_bytes) Refuse("more entries than bytes");
    return count;
  }
  bool AtEnd() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
};

// Numbers, and what consists of them alone.
template <class Archive, class... Values>
void Plain(Archive& archive, Values&... values) {
  static_assert((std::is_trivially_copyable_v<Values> && ...));
  (archive.Raw(&values, sizeof(values)), ...);
}

// A string, or a list of such.
template <class Archive, class List>
void PlainList(Archive& archive, List& list) {
  using Value = std::remove_cv_t<std::remove_reference_t<decltype(list[0])>>;
  static_assert(std::is_trivially_copyable_v<Value>);
  const std::size_t count = archive.Count(list.size(), sizeof(Value));
  if constexpr (Archive::kReads) list.resize(count);
  archive.Raw(list.data(), count * sizeof(Value));
}

template <class Archive, class List, class Visit>
void EachOf(Archive& archive, List& list, const Visit& visit) {
  const std::size_t count = archive.Count(list.size(), sizeof(std::size_t));
  if constexpr (Archive::kReads) list.resize(count);
  for (auto& entry : list) visit(archive, entry);
}

// A byte, as not every byte is a bool.
template <class Archive, class Bool>
void Flag(Archive& archive, Bool& flag) {
  auto byte = static_cast<std::uint8_t>(flag);
  Plain(archive, byte);
  if constexpr (Archive::kReads) flag = byte != 0;
}

template <class Archive, class Texture>
void VisitTexture(Archive& archive, Texture& texture) {
  PlainList(archive, texture.name);
  Plain(archive,
        texture.embedded,
        texture.wraps.u,
        texture.wraps.v,
        texture.set,
        texture.uv_scale,
        texture.uv_rotation_rad,
        texture.uv_offset);
}

template <class Archive, class Material>
void VisitMaterial(Archive& archive, Material& material) {
  PlainList(archive, material.name);
  Plain(
      archive, material.base_colour, material.alpha_cutoff, material.metallic, material.roughness);
  VisitTexture(archive, material.base_texture);
  VisitTexture(archive, material.metallic_roughness_texture);
  Flag(archive, material.blends);
  Flag(archive, material.emits);
  Flag(archive, material.has_normal_texture);
}

template <class Archive, class Mesh>
void VisitMesh(Archive& archive, Mesh& mesh) {
  PlainList(archive, mesh.name);
  Plain(archive, mesh.material, mesh.points_and_lines);
  Flag(archive, mesh.has_skin_or_morphs);
  PlainList(archive, mesh.positions);
  PlainList(archive, mesh.normals);
  PlainList(archive, mesh.colours);
  EachOf(archive, mesh.texture_uv, [](Archive& in, auto& set) { PlainList(in, set); });
  PlainList(archive, mesh.triangles);
}

template <class Archive, class Node>
void VisitNode(Archive& archive, Node& node, int level) {
  if (level >= kMostNodeLevels) Refuse("nodes that are nested too deeply");
  PlainList(archive, node.name);
  Plain(archive, node.parent_from_node);
  PlainList(archive, node.meshes);
  EachOf(archive, node.children, [level](Archive& in, auto& child) {
    VisitNode(in, child, level + 1);
  });
}

template <class Archive, class Scene>
void VisitScene(Archive& archive, Scene& scene) {
  VisitNode(archive, scene.root, 0);
  EachOf(archive, scene.meshes, [](Archive& in, auto& mesh) { VisitMesh(in, mesh); });
  EachOf(archive, scene.materials, [](Archive& in, auto& one) { VisitMaterial(in, one); });
  EachOf(archive, scene.pictures, [](Archive& in, auto& bytes) { PlainList(in, bytes); });
  Flag(archive, scene.has_animations);
}

void RequireSound(const ImportedNode& node, std::size_t mesh_count) {
  for (const std::uint32_t mesh : node.meshes) {
    if (mesh >= mesh_count) Refuse("a mesh that is not there");
  }
  for (const ImportedNode& child : node.children) RequireSound(child, mesh_count);
}

void RequireSound(const ImportedMesh& mesh) {
  const std::size_t count = mesh.positions.size();
  const auto fits = [count](const auto& list) { return list.empty() || list.size() == count; };
  if (!fits(mesh.normals) || !fits(mesh.colours) ||
      !std::all_of(mesh.texture_uv.begin(), mesh.texture_uv.end(), fits)) {
    Refuse("vertices without their normals, colours or texture coordinates");
  }
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int c = 0; c < 3; ++c) {
      if (triangle[c] >= count) {
        throw std::runtime_error("corner " + std::to_string(triangle[c]) + " of a mesh with " +
                                 std::to_string(count) + " vertices");
      }
    }
  }
}

}  // namespace

std::string BytesOf(const ImportedScene& scene) {
  Writer writer;
  VisitScene(writer, scene);
  return writer.Take();
}

ImportedScene SceneFromBytes(std::string_view bytes) {
  Reader reader(bytes);
  ImportedScene scene;
  VisitScene(reader, scene);
  if (!reader.AtEnd()) Refuse("too many bytes");
  RequireSound(scene.root, scene.meshes.size());
  for (const ImportedMesh& mesh : scene.meshes) RequireSound(mesh);
  return scene;
}

}  // namespace pleinair

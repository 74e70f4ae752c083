#include "scene/internal/mesh_collector.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "scene/internal/gltf_materials.h"

namespace pleinair {
namespace {

// Float keeps 8 mm there; below 1e4 m a millimetre.
constexpr double kMaxCoordinateM = 1e5;
// Farther off float knows no texels of a picture of more than a thousand.
constexpr double kMaxTextureUv = 1e4;

// glTF has +Y up and +Z to the front; ours has +Z up, and the front towards -Y.
glm::dmat4 ZUpFromYUp() {
  return {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
}

// assimp's name of the material of faces without one.
constexpr const char* kNoMaterial = "DefaultMaterial";

// Whether assimp invented the name for a part without one.
bool IsMadeUp(const std::string& name) {
  return name.empty() || name == "defaultobject" || name.starts_with("<STL") ||
         name.starts_with("nodes[") || name.starts_with("meshes[");
}

void AddCounts(const MeshReport& of_part, MeshReport& report) {
  report.degenerate_triangles_removed += of_part.degenerate_triangles_removed;
  report.duplicate_triangles_removed += of_part.duplicate_triangles_removed;
  report.non_finite_triangles_removed += of_part.non_finite_triangles_removed;
  report.normals_computed += of_part.normals_computed;
  report.open_edges += of_part.open_edges;
  report.non_manifold_edges += of_part.non_manifold_edges;
  report.misoriented_edges += of_part.misoriented_edges;
  report.notes.insert(report.notes.end(), of_part.notes.begin(), of_part.notes.end());
}

double AreaOf(const LooseTriangle& triangle) {
  const glm::dvec3 a = triangle.corners[0].position_m;
  const double area = 0.5 * glm::length(glm::cross(triangle.corners[1].position_m - a,
                                                   triangle.corners[2].position_m - a));
  return std::isfinite(area) ? area : 0.0;
}

// Colour of a vertex: within [0, 1], white where it is NaN.
glm::vec4 SoundColour(glm::vec4 sound) {
  for (int c = 0; c < 4; ++c) {
    sound[c] = std::isfinite(sound[c]) ? std::clamp(sound[c], 0.0f, 1.0f) : 1.0f;
  }
  return sound;
}

}  // namespace

MeshCollector::MeshCollector(const std::filesystem::path& file,
                             MeshFormat format,
                             MeshColours colours,
                             const ImportedScene& scene,
                             const ObjMaterials& obj_materials)
    : file_(file),
      format_(format),
      colours_(colours),
      scene_(scene),
      obj_materials_(obj_materials) {}

void MeshCollector::Collect(const GltfMotion* motion) {
  parts_.resize(1);
  Place root;
  if (format_ == MeshFormat::kGltf) root.root_from_node = ZUpFromYUp();
  if (motion == nullptr) {
    CollectNode(scene_.root, 0, root, nullptr);
    return;
  }
  MovingNode upright;
  upright.rest = root.root_from_node;
  root.chain.push_back(upright);
  // assimp puts a node of its own over several roots.
  if (motion->roots.size() == 1) {
    CollectNode(scene_.root, motion->roots[0], root, motion);
    return;
  }
  for (std::size_t i = 0; i < motion->roots.size() && i < scene_.root.children.size(); ++i) {
    CollectNode(scene_.root.children[i], motion->roots[i], root, motion);
  }
}

void MeshCollector::CollectNode(const ImportedNode& node,
                                int gltf_node,
                                Place place,
                                const GltfMotion* motion) {
  place.root_from_node = place.root_from_node * node.parent_from_node;
  if (motion != nullptr) {
    const auto index = static_cast<std::size_t>(gltf_node);
    if (motion->children[index].size() != node.children.size()) {
      throw std::runtime_error(file_.string() + ": nodes[" + std::to_string(gltf_node) +
                               "]: expected " + std::to_string(node.children.size()) +
                               " children, as the mesh has them");
    }
    place.chain.push_back(motion->nodes[index]);
    if (motion->nodes[index].Moves()) {
      place.part = parts_.size();
      parts_.push_back({{}, PartMotion(place.chain, motion->duration_s)});
      place.root_from_node = parts_.back().motion.FileFromPart(0.0);
    }
  }
  for (const std::uint32_t mesh : node.meshes) CollectMesh(node, scene_.meshes[mesh], place);
  for (std::size_t i = 0; i < node.children.size(); ++i) {
    const int child =
        motion != nullptr ? motion->children[static_cast<std::size_t>(gltf_node)][i] : 0;
    CollectNode(node.children[i], child, place, motion);
  }
}

void MeshCollector::CollectMesh(const ImportedNode& node,
                                const ImportedMesh& mesh,
                                const Place& place) {
  lines_and_points_ += static_cast<std::int64_t>(mesh.points_and_lines);
  if (mesh.triangles.empty()) return;
  if (mesh.has_skin_or_morphs) ++skins_and_morphs_;
  const std::uint32_t material = SourceIndex(mesh.material);
  const std::uint32_t group = GroupIndex(node, mesh);
  const SourceMaterial& source = *sources_[material];
  static const std::vector<glm::vec2> kNone;
  const std::vector<glm::vec2>& texture_uv =
      source.texture && source.texture_set < mesh.texture_uv.size()
          ? mesh.texture_uv[source.texture_set]
          : kNone;
  // Other formats do not say what scale their colours are in.
  const bool has_colours = format_ == MeshFormat::kGltf && !mesh.colours.empty();
  const glm::dmat3 linear(place.root_from_node);
  const double determinant = glm::determinant(linear);
  const bool mirrors = determinant < 0.0;
  const bool has_normals =
      !mesh.normals.empty() && format_ != MeshFormat::kStl && determinant != 0.0;
  const glm::dmat3 root_from_normal =
      has_normals ? glm::transpose(glm::inverse(linear)) : glm::dmat3(1.0);

  for (const glm::uvec3& corners : mesh.triangles) {
    LooseTriangle triangle;
    triangle.material = material;
    triangle.group = group;
    triangle.has_texture_uv = !texture_uv.empty();
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t index = corners[c];
      const auto place_in_triangle = static_cast<std::size_t>(mirrors ? 2 - c : c);
      LooseCorner& corner = triangle.corners[place_in_triangle];
      corner.position_m =
          glm::dvec3(place.root_from_node * glm::dvec4(glm::dvec3(mesh.positions[index]), 1.0));
      RequireNear(corner.position_m);
      if (has_normals) {
        corner.normal = glm::vec3(root_from_normal * glm::dvec3(mesh.normals[index]));
      }
      if (!texture_uv.empty()) {
        // Its v goes up.
        const glm::dvec2 uv =
            source.PlaceOf({texture_uv[index].x, 1.0 - double{texture_uv[index].y}});
        triangle.has_texture_uv = triangle.has_texture_uv && std::abs(uv.x) <= kMaxTextureUv &&
                                  std::abs(uv.y) <= kMaxTextureUv;
        triangle.colours.texture_uv[place_in_triangle] = glm::vec2(uv);
      }
      if (has_colours) {
        triangle.colours.vertex_colour[place_in_triangle] = SoundColour(mesh.colours[index]);
      }
    }
    if (source.texture && !triangle.has_texture_uv) ++unplaced_triangles_;
    parts_[place.part].triangles.push_back(triangle);
  }
}

void MeshCollector::RequireNear(const glm::dvec3& position_m) const {
  for (int axis = 0; axis < 3; ++axis) {
    // Not finite is another matter: such triangles are left out and counted.
    if (std::isfinite(position_m[axis]) && std::abs(position_m[axis]) > kMaxCoordinateM) {
      throw std::runtime_error(
          file_.string() + ": coordinate " + std::to_string(position_m[axis]) +
          " m: expected at most 1e5 m from the origin; move the model to a local origin");
    }
  }
}

std::uint32_t MeshCollector::SourceIndex(std::uint32_t imported) {
  const auto known = source_of_.find(imported);
  if (known != source_of_.end()) return known->second;
  SourceMaterial material = MakeMaterial(imported);
  if (material.ExceedsLimits()) {
    report_.notes.push_back("material '" + material.name + "': reflectance limited to below 1");
  }
  NoteWhatIsLeftOut(material);
  const auto source = static_cast<std::uint32_t>(sources_.size());
  sources_.push_back(std::make_shared<const SourceMaterial>(std::move(material)));
  source_of_.emplace(imported, source);
  return source;
}

void MeshCollector::NoteWhatIsLeftOut(const SourceMaterial& material) {
  const std::string label = "material '" + material.name + "': ";
  const bool by_place = colours_ == MeshColours::kByPlace;
  if (!material.unreadable_texture.empty()) {
    if (by_place) {
      throw std::runtime_error(file_.string() + ": " + label + "texture " +
                               material.unreadable_texture +
                               ": expected a readable PNG or JPEG image in the mesh's folder");
    }
    report_.notes.push_back(label + "texture " + material.unreadable_texture +
                            " cannot be read, left out");
  }
  if (material.texture && !by_place) {
    report_.notes.push_back(label + "texture replaced by its mean colour");
  }
  if (material.texture && by_place && material.texture->TimesHalved() > 0) {
    report_.notes.push_back(
        label + "texture taken at " + std::to_string(material.texture->Width()) + "x" +
        std::to_string(material.texture->Height()) + " texels, half its size or less");
  }
  if (material.opacity_left_out < 1.0f) {
    report_.notes.push_back(
        fmt::format("{}d {:g} left out, treated as opaque", label, material.opacity_left_out));
  }
  if (material.alpha_cutoff > 0.0f) {
    report_.notes.push_back(label + "alphaMode MASK " +
                            (by_place ? "does not cut hard shadows, which are of whole faces"
                                      : "left out, treated as opaque"));
  }
}

SourceMaterial MeshCollector::MakeMaterial(std::uint32_t imported) {
  SourceMaterial fallback;
  fallback.name = "default";
  if (imported >= scene_.materials.size()) return fallback;
  const ImportedMaterial& source = scene_.materials[imported];
  const std::string& name = source.name;
  if (format_ == MeshFormat::kGltf) {
    // assimp gives primitives without a material a nameless one that it puts last.
    const bool made_up = name.empty() && imported + 1 == scene_.materials.size();
    return made_up ? fallback : GltfMaterial(file_, scene_, source, textures_, report_.notes);
  }
  if (format_ != MeshFormat::kObj || name.empty() || name == kNoMaterial) {
    return fallback;
  }
  const auto defined = obj_materials_.by_name.find(name);
  if (defined != obj_materials_.by_name.end()) return defined->second;
  if (!obj_materials_.libraries.empty()) {
    throw std::runtime_error(fmt::format("{}: usemtl '{}': no material library defines it ({})",
                                         file_.string(),
                                         name,
                                         fmt::join(obj_materials_.libraries, ", ")));
  }
  fallback.name = name;
  report_.notes.push_back("material '" + name + "': no material library, taken as grey 0.5");
  return fallback;
}

std::uint32_t MeshCollector::GroupIndex(const ImportedNode& node, const ImportedMesh& mesh) {
  std::string name = node.name;
  if (IsMadeUp(name)) name = mesh.name;
  if (IsMadeUp(name) || format_ == MeshFormat::kPly) name = file_.stem().string();
  const auto index = static_cast<std::uint32_t>(group_names_.size());
  const auto [entry, is_new] = group_of_.emplace(name, index);
  if (is_new) group_names_.push_back(name);
  return entry->second;
}

void MeshCollector::SettleByPlace(std::vector<LooseTriangle>& triangles) {
  for (LooseTriangle& triangle : triangles) {
    const std::shared_ptr<const SourceMaterial>& source = sources_[triangle.material];
    // Where its places are not known a texture is of its mean.
    const bool is_placed = !source->texture || triangle.has_texture_uv;
    triangle.is_by_place = is_placed && !source->IsEvenOver(triangle.colours);
    triangle.material = materials_.Index(
        source,
        is_placed ? source->MeanOver(triangle.colours) : source->MeanAnywhere(triangle.colours),
        triangle.is_by_place);
  }
}

void MeshCollector::SettleByMaterial(std::vector<LooseTriangle>& triangles) {
  struct Sum {
    glm::dvec3 colour{0.0};
    double area_m2 = 0.0;
    glm::vec3 first{0.0f};
    bool is_one = true;  // All faces have the first one's colour, then kept bit for bit.
  };
  std::map<std::uint32_t, Sum> of_source;
  for (const LooseTriangle& triangle : triangles) {
    const glm::vec3 colour = sources_[triangle.material]->MeanAnywhere(triangle.colours);
    const auto [entry, is_new] = of_source.try_emplace(triangle.material);
    Sum& sum = entry->second;
    if (is_new) sum.first = colour;
    sum.is_one = sum.is_one && colour == sum.first;
    const double area_m2 = AreaOf(triangle);
    sum.colour += area_m2 * glm::dvec3(colour);
    sum.area_m2 += area_m2;
  }
  for (LooseTriangle& triangle : triangles) {
    const Sum& sum = of_source.at(triangle.material);
    const glm::vec3 colour =
        sum.is_one || !(sum.area_m2 > 0.0) ? sum.first : glm::vec3(sum.colour / sum.area_m2);
    triangle.material = materials_.Index(sources_[triangle.material], colour, false);
  }
}

LoadedParts MeshCollector::Finish() {
  if (lines_and_points_ > 0) {
    report_.notes.push_back(
        std::to_string(lines_and_points_) +
        " points or lines left out (fewer than three corners, as where a file is cut off)");
  }
  if (skins_and_morphs_ > 0) {
    report_.notes.emplace_back("skins and morph targets left out");
  }
  if (unplaced_triangles_ > 0 && colours_ == MeshColours::kByPlace) {
    report_.notes.push_back(std::to_string(unplaced_triangles_) +
                            " triangles without texture coordinates, or with such beyond " +
                            std::to_string(static_cast<int>(kMaxTextureUv)) +
                            ": their texture replaced by its mean colour");
  }
  LoadedParts loaded;
  for (Part& part : parts_) {
    if (colours_ == MeshColours::kByPlace) {
      SettleByPlace(part.triangles);
    } else {
      SettleByMaterial(part.triangles);
    }
    MeshPart repaired;
    MeshReport of_part;
    RepairTriangles(part.triangles, repaired.mesh, of_part);
    AddCounts(of_part, report_);
    if (repaired.mesh.Empty()) continue;
    repaired.motion = std::move(part.motion);
    loaded.parts.push_back(std::move(repaired));
  }
  if (loaded.parts.empty()) {
    throw std::runtime_error(file_.string() + ": no triangle with an area: expected a mesh");
  }
  for (MeshPart& part : loaded.parts) {
    part.mesh.materials = materials_.Materials();
    part.mesh.group_names = group_names_;
  }
  loaded.report = std::move(report_);
  return loaded;
}

}  // namespace pleinair

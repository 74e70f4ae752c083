#include "objects/object_interreflection.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// With stratified directions a share is good to about 1 / rays: half a code value.
constexpr int kRaysPerVertex = 128;

// Appends `mesh` as a group of its own.
void AppendAsGroup(const Mesh& mesh, Mesh& joined) {
  const auto group = static_cast<std::uint32_t>(joined.group_names.size());
  joined.group_names.push_back("object " + std::to_string(group));
  const auto first_vertex = static_cast<std::uint32_t>(joined.positions_m.size());
  const auto first_material = static_cast<std::uint32_t>(joined.materials.size());
  joined.positions_m.insert(
      joined.positions_m.end(), mesh.positions_m.begin(), mesh.positions_m.end());
  joined.normals.insert(joined.normals.end(), mesh.normals.begin(), mesh.normals.end());
  joined.materials.insert(joined.materials.end(), mesh.materials.begin(), mesh.materials.end());
  if (!mesh.triangle_colours.empty()) {
    joined.triangle_colours.resize(joined.triangles.size());
    joined.triangle_colours.insert(
        joined.triangle_colours.end(), mesh.triangle_colours.begin(), mesh.triangle_colours.end());
  }
  for (const glm::uvec3& triangle : mesh.triangles) {
    joined.triangles.push_back(triangle + first_vertex);
    joined.triangle_group.push_back(group);
  }
  for (const std::uint32_t material : mesh.triangle_material) {
    joined.triangle_material.push_back(first_material + material);
  }
}

GatheredRays RaysOf(const PatchScene& objects, std::span<const Receiver> vertices) {
  GatherOptions options;
  options.rays_per_receiver = kRaysPerVertex;
  return GatheredRays(objects, vertices, options);
}

std::vector<glm::vec3> HiddenFrom(const GatheredRays& rays, const PatchScene& objects) {
  return rays.FromFaces(std::vector<glm::vec3>(objects.FaceCount(), glm::vec3(1.0f)));
}

}  // namespace

ObjectInterreflection::ObjectInterreflection(const std::vector<VirtualObject>& objects) {
  for (const VirtualObject& object : objects) AppendAsGroup(object.mesh, scene_.mesh);
  if (!scene_.mesh.triangle_colours.empty()) {
    scene_.mesh.triangle_colours.resize(scene_.mesh.triangles.size());
  }
  const Mesh& mesh = scene_.mesh;
  scene_.caster = RayCaster(mesh);
  for (std::size_t v = 0; v < mesh.positions_m.size(); ++v) {
    vertices_.push_back({mesh.positions_m[v], mesh.normals[v]});
  }
  for (std::size_t face = 0; face < scene_.FaceCount(); ++face) {
    const Material& material = mesh.materials[mesh.triangle_material[face / 2]];
    face_diffuse_albedo_.push_back(material.diffuse_albedo);
    scene_.face_albedo_rgb.push_back(
        glm::min(material.diffuse_albedo + material.specular_reflectance, glm::vec3(1.0f)));
  }
  face_sun_.assign(scene_.FaceCount(), 0.0f);
  // A vertex stands for parts of its triangles, which turn away from its normal: the half space
  // behind a plane at an angle fills (1 - cos) / 2 of the view.
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::vec3 normal = scene_.FaceNormal(2 * t);
    if (!(glm::dot(normal, normal) > 0.5f)) continue;  // Without area.
    for (int k = 0; k < 3; ++k) {
      const float cosine = glm::dot(mesh.normals[mesh.triangles[t][k]], normal);
      largest_turned_away_ = std::max(largest_turned_away_, 0.5f * (1.0f - std::min(cosine, 1.0f)));
    }
  }
}

void ObjectInterreflection::CastRays() {
  if (has_cast_rays_) return;
  rays_ = RaysOf(scene_, vertices_);
  hidden_ = HiddenFrom(rays_, scene_);
  has_cast_rays_ = true;
}

std::optional<float> ObjectInterreflection::LargestHiddenUpTo(float most) {
  const auto largest_of = [](const std::vector<glm::vec3>& hidden) {
    float largest = 0.0f;
    for (const glm::vec3& of_vertex : hidden) largest = std::max(largest, of_vertex.x);
    return largest;
  };
  if (std::max(largest_turned_away_, least_known_) > most) return std::nullopt;
  if (!has_cast_rays_) {
    constexpr std::size_t kFew = 256;
    const std::size_t step = (vertices_.size() + kFew - 1) / kFew;
    std::vector<Receiver> few;
    for (std::size_t v = 0; v < vertices_.size(); v += step) few.push_back(vertices_[v]);
    least_known_ = largest_of(HiddenFrom(RaysOf(scene_, few), scene_));
    if (least_known_ > most) return std::nullopt;
  }
  CastRays();
  const float largest = std::max(largest_turned_away_, largest_of(hidden_));
  return largest <= most ? std::optional(largest) : std::nullopt;
}

void ObjectInterreflection::UpdateSun(const RayCaster& real, const glm::dvec3& sun_direction_enu) {
  const glm::vec3 to_sun(sun_direction_enu);
  const Mesh& mesh = scene_.mesh;
  tbb::parallel_for(std::size_t{0}, face_sun_.size(), [&](std::size_t face) {
    face_sun_[face] = 0.0f;
    const glm::vec3 normal = scene_.FaceNormal(face);
    const float cosine = glm::dot(normal, to_sun);
    if (!(cosine > 0.0f) || !(to_sun.z > 0.0f)) return;
    const glm::uvec3& corners = mesh.triangles[face / 2];
    const glm::vec3 middle_m =
        (mesh.positions_m[corners.x] + mesh.positions_m[corners.y] + mesh.positions_m[corners.z]) /
        3.0f;
    const glm::vec3 start_m = OffsetFromSurface(middle_m, normal);
    if (!real.Occluded(start_m, to_sun) && !scene_.caster.Occluded(start_m, to_sun)) {
      face_sun_[face] = cosine;
    }
  });
}

std::vector<glm::vec3> ObjectInterreflection::FaceRadiosity(
    const DirectionalLight& sun, std::span<const std::vector<glm::vec3>> vertex_irradiance) const {
  std::vector<glm::vec3> radiosity(scene_.FaceCount());
  const glm::vec3 sun_rgb(sun.irradiance_rgb);
  std::size_t first_vertex = 0;
  std::size_t face = 0;
  for (const std::vector<glm::vec3>& irradiance : vertex_irradiance) {
    const std::size_t end = first_vertex + irradiance.size();
    for (; face < radiosity.size(); ++face) {
      const glm::uvec3& corners = scene_.mesh.triangles[face / 2];
      if (corners.x >= end) break;
      const glm::vec3 mean =
          (irradiance[corners.x - first_vertex] + irradiance[corners.y - first_vertex] +
           irradiance[corners.z - first_vertex]) /
          3.0f;
      radiosity[face] = scene_.face_albedo_rgb[face] * mean +
                        face_diffuse_albedo_[face] * face_sun_[face] * sun_rgb;
    }
    first_vertex = end;
  }
  return radiosity;
}

void ObjectInterreflection::Apply(const DirectionalLight& sun,
                                  std::span<std::vector<glm::vec3>> vertex_irradiance,
                                  std::span<const glm::vec3> direct) {
  if (!direct.empty() && direct.size() != vertices_.size()) {
    throw std::invalid_argument(std::string("object interreflection: direct has ") +
                                std::to_string(direct.size()) + " entries, expected " +
                                std::to_string(vertices_.size()) + ", one a vertex");
  }
  CastRays();
  const auto direct_at = [&](std::size_t vertex) {
    return direct.empty() ? glm::vec3(0.0f) : direct[vertex];
  };
  std::size_t first_vertex = 0;
  for (std::vector<glm::vec3>& irradiance : vertex_irradiance) {
    for (std::size_t v = 0; v < irradiance.size(); ++v) {
      irradiance[v] += direct_at(first_vertex + v);
    }
    first_vertex += irradiance.size();
  }
  const std::vector<glm::vec3> radiosity =
      FaceRadiosity(sun, {vertex_irradiance.data(), vertex_irradiance.size()});
  first_vertex = 0;
  for (std::vector<glm::vec3>& irradiance : vertex_irradiance) {
    tbb::parallel_for(std::size_t{0}, irradiance.size(), [&](std::size_t v) {
      const std::size_t vertex = first_vertex + v;
      const glm::vec3 of_volume = irradiance[v] - direct_at(vertex);
      irradiance[v] = of_volume * (1.0f - hidden_[vertex]) + direct_at(vertex) +
                      rays_.FromFacesAt(vertex, radiosity);
    });
    first_vertex += irradiance.size();
  }
}

}  // namespace pleinair

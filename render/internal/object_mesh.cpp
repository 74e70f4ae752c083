#include "render/internal/object_mesh.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <unordered_map>

#include <glm/common.hpp>

#include "render/internal/draw_count.h"

namespace pleinair {
namespace {

struct Vertex {
  glm::vec4 position;
  glm::vec3 normal;
  glm::vec3 diffuse;
  glm::vec4 specular_alpha;
};

bool IsGlossy(const Material& material) {
  const glm::vec3& k = material.specular_reflectance;
  return std::max({k.r, k.g, k.b}) > 0.0f;
}

void Attribute(GLuint index, int components, std::size_t offset) {
  glEnableVertexAttribArray(index);
  glVertexAttribPointer(
      index, components, GL_FLOAT, GL_FALSE, sizeof(Vertex), reinterpret_cast<const void*>(offset));
}

void DrawTriangles(std::size_t first, std::size_t count) {
  if (count == 0) return;
  CountDraw();
  glDrawElements(GL_TRIANGLES,
                 static_cast<GLsizei>(3 * count),
                 GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(first * sizeof(glm::uvec3)));
}

}  // namespace

ObjectMesh::ObjectMesh()
    : vertex_array_(MakeVertexArray()),
      vertices_(MakeBuffer()),
      irradiance_(MakeBuffer()),
      indices_(MakeBuffer()),
      sunlit_indices_(MakeBuffer()) {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.Name());
  Attribute(0, 4, offsetof(Vertex, position));
  Attribute(1, 3, offsetof(Vertex, normal));
  Attribute(2, 3, offsetof(Vertex, diffuse));
  Attribute(3, 4, offsetof(Vertex, specular_alpha));
  glBindBuffer(GL_ARRAY_BUFFER, irradiance_.Name());
  glEnableVertexAttribArray(4);
  glVertexAttribPointer(4, 3, GL_FLOAT, GL_FALSE, sizeof(glm::vec3), nullptr);
  glBindVertexArray(0);
}

void ObjectMesh::Upload(std::span<const Mesh* const> objects,
                        std::span<const glm::vec3> positions) {
  std::vector<Vertex> vertices;
  triangles_.clear();
  sources_.clear();
  positions_.clear();
  material_of_.clear();
  materials_.clear();
  std::size_t first_position = 0;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const Mesh& mesh = *objects[o];
    const auto first_material = static_cast<std::uint32_t>(materials_.size());
    materials_.insert(materials_.end(), mesh.materials.begin(), mesh.materials.end());
    if (mesh.materials.empty()) materials_.emplace_back();
    std::unordered_map<std::uint64_t, std::uint32_t> vertex_of;  // (vertex, material) to ours.
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::uint32_t material_index =
          first_material + (mesh.triangle_material.empty() || mesh.materials.empty()
                                ? 0
                                : mesh.triangle_material[t]);
      const Material& material = materials_[material_index];
      glm::uvec3 triangle;
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t source = mesh.triangles[t][corner];
        const auto [entry, is_new] =
            vertex_of.try_emplace((static_cast<std::uint64_t>(source) << 32) | material_index,
                                  static_cast<std::uint32_t>(vertices.size()));
        if (is_new) {
          vertices.push_back(
              {glm::vec4(positions[first_position + source], 1.0f),
               mesh.normals[source],
               material.diffuse_albedo,
               glm::vec4(material.specular_reflectance, material.roughness * material.roughness)});
          sources_.push_back({static_cast<std::uint32_t>(o), source});
          positions_.push_back(positions[first_position + source]);
          material_of_.push_back(material_index);
        }
        triangle[corner] = entry->second;
      }
      triangles_.push_back(triangle);
    }
    first_position += mesh.positions_m.size();
  }
  front_in_sun_count_ = 0;
  sunlit_triangles_.clear();
  glBindVertexArray(vertex_array_.Name());
  UploadBuffer(vertices_, GL_ARRAY_BUFFER, vertices, GL_STATIC_DRAW);
  UploadBuffer(indices_, GL_ELEMENT_ARRAY_BUFFER, triangles_, GL_STATIC_DRAW);
  glBindVertexArray(0);
}

void ObjectMesh::UploadIrradiance(std::span<const std::vector<glm::vec3>> vertex_irradiance,
                                  float gain) {
  irradiance_values_.assign(sources_.size(), glm::vec3(0.0f));
  if (!vertex_irradiance.empty()) {
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      irradiance_values_[i] = gain * vertex_irradiance[sources_[i].object][sources_[i].vertex];
    }
  }
  UploadBuffer(irradiance_, GL_ARRAY_BUFFER, irradiance_values_, GL_STREAM_DRAW);
}

void ObjectMesh::RadianceAtVertices(std::span<const std::vector<glm::vec3>> vertex_irradiance,
                                    float gain,
                                    bool mirrors,
                                    std::vector<glm::vec3>& radiance) const {
  radiance.assign(sources_.size(), glm::vec3(0.0f));
  if (vertex_irradiance.empty()) return;
  std::vector<glm::vec3> of_unit;  // Per material, under a unit of irradiance.
  for (const Material& material : materials_) {
    const glm::vec3 albedo =
        mirrors && IsGlossy(material)
            ? material.diffuse_albedo
            : glm::min(material.diffuse_albedo + material.specular_reflectance, glm::vec3(1.0f));
    of_unit.push_back(gain * std::numbers::inv_pi_v<float> * albedo);
  }
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    radiance[i] =
        of_unit[material_of_[i]] * vertex_irradiance[sources_[i].object][sources_[i].vertex];
  }
}

std::vector<bool> ObjectMesh::GlossyVertices() const {
  std::vector<bool> is_glossy(sources_.size());
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    is_glossy[i] = IsGlossy(materials_[material_of_[i]]);
  }
  return is_glossy;
}

void ObjectMesh::UploadSunlitTriangles(std::span<const std::int8_t> sides) {
  sunlit_triangles_.clear();
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (sides[t] > 0) sunlit_triangles_.push_back(triangles_[t]);
  }
  front_in_sun_count_ = sunlit_triangles_.size();
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (sides[t] < 0) sunlit_triangles_.push_back(triangles_[t]);
  }
  glBindVertexArray(vertex_array_.Name());
  UploadBuffer(sunlit_indices_, GL_ELEMENT_ARRAY_BUFFER, sunlit_triangles_, GL_STREAM_DRAW);
  glBindVertexArray(0);
}

void ObjectMesh::Draw() const {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.Name());
  DrawTriangles(0, triangles_.size());
}

void ObjectMesh::DrawTrianglesWithFrontInSun() const {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, sunlit_indices_.Name());
  DrawTriangles(0, front_in_sun_count_);
}

void ObjectMesh::DrawTrianglesWithBackInSun() const {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, sunlit_indices_.Name());
  DrawTriangles(front_in_sun_count_, sunlit_triangles_.size() - front_in_sun_count_);
}

}  // namespace pleinair

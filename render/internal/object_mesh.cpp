#include "render/internal/object_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <glm/common.hpp>

#include "render/internal/draw_count.h"
#include "scene/low_discrepancy.h"
#include "scene/textured_material.h"

namespace pleinair {
namespace {

struct Vertex {
  glm::vec4 position;
  glm::vec3 normal;
  glm::vec3 diffuse;
  glm::vec4 specular_alpha;
};

struct PlaceOfVertex {
  glm::vec2 texture_uv{0.0f};
  glm::vec4 colour{1.0f};
};

// A vertex of an object and its place, compared bit for bit.
using PlaceKey = std::array<std::uint32_t, 7>;

PlaceKey KeyOf(std::uint32_t vertex, const PlaceOfVertex& place) {
  const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  return {vertex,
          bits(place.texture_uv.x),
          bits(place.texture_uv.y),
          bits(place.colour.r),
          bits(place.colour.g),
          bits(place.colour.b),
          bits(place.colour.a)};
}

// A mesh without materials gets a default one.
const Material* MaterialOf(const Mesh& mesh, std::size_t triangle) {
  if (mesh.triangle_material.empty() || mesh.materials.empty()) return nullptr;
  return &mesh.materials[mesh.triangle_material[triangle]];
}

bool IsGlossy(const Material& material) {
  if (material.by_place) return material.by_place->IsGlossy();
  const glm::vec3& k = material.specular_reflectance;
  return std::max({k.r, k.g, k.b}) > 0.0f;
}

// Where OpenGL takes an offset into a buffer for a pointer.
const void* OffsetPointer(std::uintptr_t bytes) { return std::bit_cast<const void*>(bytes); }

template <typename Value>
void Attribute(GLuint index, int components, std::size_t offset) {
  glEnableVertexAttribArray(index);
  glVertexAttribPointer(
      index, components, GL_FLOAT, GL_FALSE, sizeof(Value), OffsetPointer(offset));
}

void DrawTriangles(std::size_t first, std::size_t count) {
  if (count == 0) return;
  CountDraw();
  glDrawElements(GL_TRIANGLES,
                 static_cast<GLsizei>(3 * count),
                 GL_UNSIGNED_INT,
                 OffsetPointer(first * sizeof(glm::uvec3)));
}

}  // namespace

ObjectMesh::ObjectMesh()
    : vertex_array_(MakeVertexArray()),
      vertices_(MakeBuffer()),
      irradiance_(MakeBuffer()),
      indices_(MakeBuffer()),
      sunlit_indices_(MakeBuffer()),
      places_(MakeBuffer()) {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.Name());
  Attribute<Vertex>(0, 4, offsetof(Vertex, position));
  Attribute<Vertex>(1, 3, offsetof(Vertex, normal));
  Attribute<Vertex>(2, 3, offsetof(Vertex, diffuse));
  Attribute<Vertex>(3, 4, offsetof(Vertex, specular_alpha));
  glBindBuffer(GL_ARRAY_BUFFER, irradiance_.Name());
  glEnableVertexAttribArray(4);
  glVertexAttribPointer(4, 3, GL_FLOAT, GL_FALSE, sizeof(glm::vec3), nullptr);
  glBindVertexArray(0);
}

void ObjectMesh::MakeBatches(std::span<const Mesh* const> objects) {
  batches_.assign(1, {});
  std::unordered_map<const TexturedMaterial*, std::size_t> batch_of;
  std::vector<std::size_t> batch_of_triangle;
  std::vector<std::shared_ptr<const Texture>> textures;
  for (const Mesh* mesh : objects) {
    for (std::size_t t = 0; t < mesh->triangles.size(); ++t) {
      const Material* material = MaterialOf(*mesh, t);
      const auto* by_place = material != nullptr ? material->by_place.get() : nullptr;
      std::size_t batch = 0;
      if (by_place != nullptr) {
        const auto [entry, is_new] = batch_of.try_emplace(by_place, batches_.size());
        batch = entry->second;
        if (is_new) {
          batches_.push_back(
              {.by_place = material->by_place, .is_cut_out = by_place->alpha_cutoff > 0.0f});
          if (by_place->texture) textures.push_back(by_place->texture);
        }
      }
      ++batches_[batch].count;
      batch_of_triangle.push_back(batch);
    }
  }
  textures_.Keep(textures);
  std::vector<std::size_t> order(batches_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_partition(
      order.begin(), order.end(), [&](std::size_t b) { return !batches_[b].is_cut_out; });
  std::size_t first = 0;
  for (const std::size_t b : order) {
    batches_[b].first = first;
    first += batches_[b].count;
  }
  number_of_triangle_.resize(batch_of_triangle.size());
  std::vector<std::size_t> next(batches_.size());
  for (std::size_t b = 0; b < next.size(); ++b) next[b] = batches_[b].first;
  for (std::size_t t = 0; t < batch_of_triangle.size(); ++t) {
    number_of_triangle_[next[batch_of_triangle[t]]++] = t;
  }
  std::vector<Batch> sorted;
  sorted.reserve(order.size());
  for (const std::size_t b : order) sorted.push_back(std::move(batches_[b]));
  batches_ = std::move(sorted);
}

void ObjectMesh::Upload(std::span<const Mesh* const> objects,
                        std::span<const glm::vec3> positions) {
  std::vector<Vertex> vertices;
  std::vector<PlaceOfVertex> places;
  triangles_.clear();
  by_place_.clear();
  sources_.clear();
  positions_.clear();
  material_of_.clear();
  materials_.clear();
  MakeBatches(objects);
  // First triangle of each object.
  std::vector<std::size_t> first_triangle;
  std::vector<std::size_t> first_position;
  std::vector<std::uint32_t> first_material;
  std::size_t triangle_count = 0;
  std::size_t position_count = 0;
  for (const Mesh* mesh : objects) {
    first_triangle.push_back(triangle_count);
    first_position.push_back(position_count);
    first_material.push_back(static_cast<std::uint32_t>(materials_.size()));
    triangle_count += mesh->triangles.size();
    position_count += mesh->positions_m.size();
    materials_.insert(materials_.end(), mesh->materials.begin(), mesh->materials.end());
    if (mesh->materials.empty()) materials_.emplace_back();
  }
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_of;  // (vertex, material) to ours.
  std::unordered_map<PlaceKey, std::uint32_t, HashOfWords> vertex_at;  // By place.
  std::size_t last_object = objects.size();
  for (const Batch& batch : batches_) {
    last_object = objects.size();
    for (std::size_t n = batch.first; n < batch.first + batch.count; ++n) {
      const std::size_t number = number_of_triangle_[n];
      const auto o = static_cast<std::size_t>(
          std::upper_bound(first_triangle.begin(), first_triangle.end(), number) -
          first_triangle.begin() - 1);
      if (o != last_object) {
        vertex_of.clear();
        vertex_at.clear();
        last_object = o;
      }
      const Mesh& mesh = *objects[o];
      const std::size_t t = number - first_triangle[o];
      const std::uint32_t material_index =
          first_material[o] + (MaterialOf(mesh, t) == nullptr ? 0 : mesh.triangle_material[t]);
      const Material& material = materials_[material_index];
      glm::uvec3 triangle;
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t source = mesh.triangles[t][corner];
        const auto next = static_cast<std::uint32_t>(vertices.size());
        bool is_new = false;
        PlaceOfVertex place;
        if (batch.by_place) {
          const TriangleColours& colours = mesh.triangle_colours[t];
          place = {colours.texture_uv[static_cast<std::size_t>(corner)],
                   colours.vertex_colour[static_cast<std::size_t>(corner)]};
          const auto found = vertex_at.try_emplace(KeyOf(source, place), next);
          is_new = found.second;
          triangle[corner] = found.first->second;
        } else {
          const auto found = vertex_of.try_emplace(
              (static_cast<std::uint64_t>(source) << 32) | material_index, next);
          is_new = found.second;
          triangle[corner] = found.first->second;
        }
        if (!is_new) continue;
        const glm::vec3& position = positions[first_position[o] + source];
        vertices.push_back(
            {glm::vec4(position, 1.0f),
             mesh.normals[source],
             material.diffuse_albedo,
             glm::vec4(material.specular_reflectance, material.roughness * material.roughness)});
        if (batches_.size() > 1) places.push_back(place);
        sources_.push_back({static_cast<std::uint32_t>(o), source});
        positions_.push_back(position);
        material_of_.push_back(material_index);
      }
      triangles_.push_back(triangle);
      if (batch.by_place) by_place_.push_back({batch.by_place.get(), mesh.triangle_colours[t]});
    }
  }
  for (Batch& batch : batches_) batch.front_count = batch.back_count = 0;
  sunlit_triangles_.clear();
  glBindVertexArray(vertex_array_.Name());
  UploadBuffer(vertices_, GL_ARRAY_BUFFER, vertices, GL_STATIC_DRAW);
  UploadBuffer(indices_, GL_ELEMENT_ARRAY_BUFFER, triangles_, GL_STATIC_DRAW);
  // An attribute that is switched on needs storage, also where no pass makes use of it.
  irradiance_values_.assign(sources_.size(), glm::vec3(0.0f));
  UploadBuffer(irradiance_, GL_ARRAY_BUFFER, irradiance_values_, GL_STREAM_DRAW);
  if (places.empty()) {
    glDisableVertexAttribArray(5);
    glDisableVertexAttribArray(6);
  } else {
    UploadBuffer(places_, GL_ARRAY_BUFFER, places, GL_STATIC_DRAW);
    Attribute<PlaceOfVertex>(5, 2, offsetof(PlaceOfVertex, texture_uv));
    Attribute<PlaceOfVertex>(6, 4, offsetof(PlaceOfVertex, colour));
  }
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
    glm::vec3 albedo(1.0f);
    if (!material.by_place) {
      albedo =
          mirrors && IsGlossy(material)
              ? material.diffuse_albedo
              : glm::min(material.diffuse_albedo + material.specular_reflectance, glm::vec3(1.0f));
    }
    of_unit.push_back(gain * std::numbers::inv_pi_v<float> * albedo);
  }
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    radiance[i] =
        of_unit[material_of_[i]] * vertex_irradiance[sources_[i].object][sources_[i].vertex];
  }
}

std::vector<bool> ObjectMesh::GlossyVertices() const {
  std::vector<bool> of_material;
  for (const Material& material : materials_) of_material.push_back(IsGlossy(material));
  std::vector<bool> is_glossy(sources_.size());
  for (std::size_t i = 0; i < sources_.size(); ++i) is_glossy[i] = of_material[material_of_[i]];
  return is_glossy;
}

void ObjectMesh::UploadSunlitTriangles(std::span<const std::int8_t> sides) {
  sunlit_triangles_.clear();
  const auto add = [&](const Batch& batch, bool is_front) {
    for (std::size_t n = batch.first; n < batch.first + batch.count; ++n) {
      const std::int8_t side = sides[number_of_triangle_[n]];
      if (is_front ? side > 0 : side < 0) sunlit_triangles_.push_back(triangles_[n]);
    }
  };
  for (Batch& batch : batches_) {
    batch.first_front = sunlit_triangles_.size();
    add(batch, true);
    batch.front_count = sunlit_triangles_.size() - batch.first_front;
    batch.first_back = sunlit_triangles_.size();
    add(batch, false);
    batch.back_count = sunlit_triangles_.size() - batch.first_back;
  }
  glBindVertexArray(vertex_array_.Name());
  UploadBuffer(sunlit_indices_, GL_ELEMENT_ARRAY_BUFFER, sunlit_triangles_, GL_STREAM_DRAW);
  glBindVertexArray(0);
}

void ObjectMesh::Draw(std::size_t first, std::size_t count) const {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.Name());
  DrawTriangles(first, count);
}

void ObjectMesh::DrawSunlit(std::size_t first, std::size_t count) const {
  glBindVertexArray(vertex_array_.Name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, sunlit_indices_.Name());
  DrawTriangles(first, count);
}

}  // namespace pleinair

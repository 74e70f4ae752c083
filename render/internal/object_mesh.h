// Virtual objects on the device, ready to be shaded.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "render/internal/gl_object.h"
#include "render/internal/texture_store.h"
#include "render/internal/vertex_shares.h"
#include "scene/mesh.h"

namespace pleinair {

// All objects in one vertex buffer. A vertex that triangles of several materials share is stored
// once for each. Attributes: 0 (position, 1), 1 normal, 2 diffuse albedo, 3 (specular reflectance,
// GGX alpha), 4 irradiance. Materials by place also have 5, the texture coordinates, and 6, the
// vertex' colour; of their 2 and 3 only alpha has a meaning. A vertex is stored once for each
// texture coordinate, too.
class ObjectMesh {
 public:
  // Triangles that are drawn together.
  struct Batch {
    std::shared_ptr<const TexturedMaterial> by_place;  // Null: each has its own material's colour.
    bool is_cut_out = false;                           // Its texture says where it is.
    std::size_t first = 0;                             // Into Triangles().
    std::size_t count = 0;
    // Triangles with their front, and with their back, in the sun.
    std::size_t first_front = 0;
    std::size_t front_count = 0;
    std::size_t first_back = 0;
    std::size_t back_count = 0;
  };

  ObjectMesh();

  // `positions` are all objects' vertices, one object after the other, in the renderer's own frame.
  void Upload(std::span<const Mesh* const> objects, std::span<const glm::vec3> positions);

  // Per object and vertex; an empty span means none.
  void UploadIrradiance(std::span<const std::vector<glm::vec3>> vertex_irradiance, float gain);

  // Radiance under that irradiance, per vertex on the device; see ObjectLayerPass. `mirrors`: that
  // of glossy surfaces without what they mirror. For materials by place that of white ones.
  void RadianceAtVertices(std::span<const std::vector<glm::vec3>> vertex_irradiance,
                          float gain,
                          bool mirrors,
                          std::vector<glm::vec3>& radiance) const;

  // The data on the device: triangles in batches, and vertices. The first batch has triangles of
  // one colour each, and may be empty; the last ones have those with cut-outs. Within a batch
  // triangles are ordered by object.
  std::span<const Batch> Batches() const { return batches_; }
  std::span<const glm::uvec3> Triangles() const { return triangles_; }
  // The last triangles, which have materials by place.
  std::span<const TriangleByPlace> TrianglesByPlace() const { return by_place_; }
  TextureStore& Textures() { return textures_; }
  std::span<const glm::vec3> Positions() const { return positions_; }
  std::vector<bool> GlossyVertices() const;

  // Per triangle of all objects, which side the sun may light: 1 front, -1 back, 0 none.
  void UploadSunlitTriangles(std::span<const std::int8_t> sides);

  void Draw(std::size_t first, std::size_t count) const;
  void DrawSunlit(std::size_t first, std::size_t count) const;

 private:
  struct Source {
    std::uint32_t object = 0;
    std::uint32_t vertex = 0;
  };

  void MakeBatches(std::span<const Mesh* const> objects);

  GlObject vertex_array_;
  GlObject vertices_;
  GlObject irradiance_;
  GlObject indices_;
  GlObject sunlit_indices_;
  GlObject places_;
  TextureStore textures_;
  std::vector<Batch> batches_;
  std::vector<glm::uvec3> triangles_;
  std::vector<std::size_t> number_of_triangle_;  // Among all objects' triangles.
  std::vector<TriangleByPlace> by_place_;
  // Per device vertex.
  std::vector<Source> sources_;
  std::vector<glm::vec3> positions_;
  std::vector<std::uint32_t> material_of_;  // Into materials_.
  std::vector<Material> materials_;         // The materials of all objects.
  std::vector<glm::vec3> irradiance_values_;
  std::vector<glm::uvec3> sunlit_triangles_;
};

}  // namespace pleinair

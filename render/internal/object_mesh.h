// Virtual objects on the device, ready to be shaded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "render/internal/gl_object.h"
#include "scene/mesh.h"

namespace pleinair {

// All objects in one vertex buffer. A vertex that triangles of several materials share is there
// once for each. Attributes: 0 (position, 1), 1 normal, 2 diffuse albedo, 3 (specular reflectance,
// GGX alpha), 4 irradiance.
class ObjectMesh {
 public:
  ObjectMesh();

  // `positions` are all objects' vertices, one object after the other, in the renderer's own frame.
  void Upload(std::span<const Mesh* const> objects, std::span<const glm::vec3> positions);

  // Per object and vertex; an empty span means none.
  void UploadIrradiance(std::span<const std::vector<glm::vec3>> vertex_irradiance, float gain);

  // Radiance under that irradiance, per vertex on the device; see ObjectLayerPass. `mirrors`: that
  // of glossy surfaces without what they mirror.
  void RadianceAtVertices(std::span<const std::vector<glm::vec3>> vertex_irradiance,
                          float gain,
                          bool mirrors,
                          std::vector<glm::vec3>& radiance) const;

  // What is on the device: triangles of all objects, one object after the other, and vertices.
  std::span<const glm::uvec3> Triangles() const { return triangles_; }
  std::span<const glm::vec3> Positions() const { return positions_; }
  std::vector<bool> GlossyVertices() const;

  // Per triangle of all objects, which side the sun may light: 1 front, -1 back, 0 none.
  void UploadSunlitTriangles(std::span<const std::int8_t> sides);

  void Draw() const;
  void DrawTrianglesWithFrontInSun() const;
  void DrawTrianglesWithBackInSun() const;

 private:
  struct Source {
    std::uint32_t object = 0;
    std::uint32_t vertex = 0;
  };

  GlObject vertex_array_;
  GlObject vertices_;
  GlObject irradiance_;
  GlObject indices_;
  GlObject sunlit_indices_;
  std::vector<glm::uvec3> triangles_;
  // Per device vertex.
  std::vector<Source> sources_;
  std::vector<glm::vec3> positions_;
  std::vector<std::uint32_t> material_of_;  // Into materials_.
  std::vector<Material> materials_;         // Of all objects.
  std::vector<glm::vec3> irradiance_values_;
  std::vector<glm::uvec3> sunlit_triangles_;
  std::size_t front_in_sun_count_ = 0;  // Triangles; those with their back in the sun follow.
};

}  // namespace pleinair

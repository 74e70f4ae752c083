// Triangle meshes with materials, as plain data. For files see mesh_io.h.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace pleinair {

struct TexturedMaterial;  // scene/textured_material.h

// A GGX surface with a diffuse part.
struct Material {
  std::string name;
  glm::vec3 diffuse_albedo{0.5f};        // Linear RGB in [0, 1).
  glm::vec3 specular_reflectance{0.0f};  // Linear RGB at normal incidence.
  float roughness = 1.0f;                // GGX with alpha = roughness^2.
  // For a colour that varies with the place: its texture. The values above are then the means over
  // a triangle. Null: one colour.
  std::shared_ptr<const TexturedMaterial> by_place{};
};

// Texture coordinates and colours of a triangle's corners; linear in between.
struct TriangleColours {
  // Right and down from the picture's upper left corner; (1, 1) is its lower right one.
  std::array<glm::vec2, 3> texture_uv{};
  // Linear RGB and alpha, each in [0, 1].
  std::array<glm::vec4, 3> vertex_colour{glm::vec4(1.0f), glm::vec4(1.0f), glm::vec4(1.0f)};
};

// positions_m and normals have one entry for each vertex; the triangle_* one for each triangle.
// Winding is counter-clockwise seen from outside, where the mesh has an outside.
struct Mesh {
  std::vector<glm::vec3> positions_m;
  std::vector<glm::vec3> normals;  // Shading normals, unit.
  std::vector<glm::uvec3> triangles;
  std::vector<std::uint32_t> triangle_material;   // Into materials.
  std::vector<std::uint32_t> triangle_group;      // Into group_names.
  std::vector<TriangleColours> triangle_colours;  // Empty where no material is looked up by place.
  std::vector<Material> materials;
  std::vector<std::string> group_names;  // OBJ objects/groups, glTF nodes.

  bool Empty() const { return triangles.empty(); }
};

// Axis-aligned; metres.
struct BoundingBox {
  glm::vec3 lower_m{0.0f};
  glm::vec3 upper_m{0.0f};
};

// Tight around the vertices that triangles use; throws std::invalid_argument for an empty mesh.
BoundingBox BoundingBoxOf(const Mesh& mesh);
// Set bits of the index mean the upper corner: 1 along x, 2 along y, 4 along z.
std::array<glm::vec3, 8> CornersOf(const BoundingBox& box);

// Returns the mesh moved by an affine transform. Normals use the inverse transpose, and the winding
// is reversed where the transform mirrors.
Mesh TransformMesh(const glm::dmat4& target_from_mesh, const Mesh& mesh);

// Unit normal by winding; zero for a triangle without area.
glm::vec3 TriangleNormal(const Mesh& mesh, std::uint32_t triangle);

}  // namespace pleinair

// A material whose colour varies by a texture or by colours of vertices.
#pragma once

#include <memory>
#include <string>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "scene/mesh.h"
#include "scene/texture.h"

namespace pleinair {

// The colour of a place is that of the texture there, times base_colour, times the vertices' colour
// between them (glTF 2.0, section 3.9.2); so is its alpha.
struct TexturedMaterial {
  std::string name;
  glm::vec3 base_colour{0.5f};
  float base_alpha = 1.0f;
  // Share of metal, which mirrors its colour and has no diffuse part. For the rest the colour is
  // the diffuse albedo, and `dielectric_reflectance` is mirrored.
  float metallic = 0.0f;
  glm::vec3 dielectric_reflectance{0.0f};
  float roughness = 1.0f;
  std::shared_ptr<const Texture> texture;  // Null: white.
  TextureWraps wraps;
  // Places of less alpha are cut out. 0: none is.
  float alpha_cutoff = 0.0f;

  static constexpr float kMaxAlbedo = 0.98f;
  struct Reflectances {
    glm::vec3 diffuse_albedo{0.0f};
    glm::vec3 specular_reflectance{0.0f};
  };

  // Reflectances of a place where texture times vertices has this colour; limited so that
  // interreflection converges.
  Reflectances Of(const glm::vec3& colour) const;
  Material WithColour(const glm::vec3& colour) const;
  // For the mean colour.
  Material Mean() const;
  // Whether WithColour must limit it.
  bool ExceedsLimits() const;
  // No place is brighter, in any channel.
  Reflectances Brightest() const;
  // Whether any place may mirror something.
  bool IsGlossy() const;

  // Colour of texture times vertices: at a place, at a level of the texture; and the mean over a
  // triangle.
  glm::vec4 ColourAt(const glm::vec2& uv, float level, const glm::vec4& vertex_colour) const;
  glm::vec3 MeanOver(const TriangleColours& colours) const;
  // The same for a triangle without texture coordinates.
  glm::vec3 MeanAnywhere(const TriangleColours& colours) const;
  // Whether that triangle has one colour and no cut-out place.
  bool IsEvenOver(const TriangleColours& colours) const;
};

// Gives each triangle of a material by place its own material, with the means over that triangle,
// rounded to 128 steps of display code; equal ones are shared. Other materials only change their
// index. A mesh without such materials is not changed.
void TakeMeansOverTriangles(Mesh& mesh);

}  // namespace pleinair

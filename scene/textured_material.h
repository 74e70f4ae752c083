// A material of another colour wherever its texture, or the colours of vertices, say so.
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
  // Share of a metal, which mirrors its colour and has no diffuse part; the rest has the colour for
  // its diffuse albedo and mirrors `dielectric_reflectance`.
  float metallic = 0.0f;
  glm::vec3 dielectric_reflectance{0.0f};
  float roughness = 1.0f;
  std::shared_ptr<const Texture> texture;  // Null: white.
  TextureWraps wraps;
  // Places of less alpha are not there. 0: all are.
  float alpha_cutoff = 0.0f;

  static constexpr float kMaxAlbedo = 0.98f;
  struct Reflectances {
    glm::vec3 diffuse_albedo{0.0f};
    glm::vec3 specular_reflectance{0.0f};
  };

  // Where texture and vertices are of this colour together; within what interreflection that is to
  // converge allows.
  Reflectances Of(const glm::vec3& colour) const;
  Material WithColour(const glm::vec3& colour) const;
  // Where they are of their means.
  Material Mean() const;
  // Whether WithColour has to limit it.
  bool ExceedsLimits() const;
  // No place is brighter, in any channel.
  Reflectances Brightest() const;
  // Whether any place may mirror something.
  bool IsGlossy() const;

  // Colour of texture times vertices: at a place, at a level of the texture; and the mean over a
  // triangle.
  glm::vec4 ColourAt(const glm::vec2& uv, float level, const glm::vec4& vertex_colour) const;
  glm::vec3 MeanOver(const TriangleColours& colours) const;
  // The same where its place in the texture is not known.
  glm::vec3 MeanAnywhere(const TriangleColours& colours) const;
  // Whether that triangle is of one colour, and all there.
  bool IsEvenOver(const TriangleColours& colours) const;
};

// Gives each triangle of a material by place one of its own, with the means over that triangle, to
// the next of 128 steps of display code; triangles that agree share it. What is not by place stays,
// but for its number; a mesh without such materials stays as it is.
void TakeMeansOverTriangles(Mesh& mesh);

}  // namespace pleinair

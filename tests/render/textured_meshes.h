// Meshes with pictures on them, for the render tests.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <utility>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "scene/mesh.h"
#include "scene/textured_material.h"

namespace pleinair::test {

inline Texture::Codes RandomCodes(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Texture::Codes codes(width, height);
  for (glm::u8vec4& code : codes.pixels) {
    code = glm::u8vec4(random() % 256, random() % 256, random() % 256, random() % 256);
  }
  return codes;
}

inline std::shared_ptr<TexturedMaterial> Painted(Texture::Codes codes) {
  auto material = std::make_shared<TexturedMaterial>();
  material->base_colour = glm::vec3(0.9f);
  material->texture = std::make_shared<const Texture>(std::move(codes));
  return material;
}

// `uv_of` of a vertex' position.
template <typename UvOf>
Mesh Textured(Mesh mesh, const std::shared_ptr<const TexturedMaterial>& material, UvOf&& uv_of) {
  mesh.materials.assign(1, material->Mean());
  mesh.materials[0].by_place = material;
  for (const glm::uvec3& triangle : mesh.triangles) {
    TriangleColours colours;
    for (int k = 0; k < 3; ++k) {
      colours.texture_uv[static_cast<std::size_t>(k)] = uv_of(mesh.positions_m[triangle[k]]);
    }
    mesh.triangle_colours.push_back(colours);
  }
  TakeMeansOverTriangles(mesh);
  return mesh;
}

}  // namespace pleinair::test

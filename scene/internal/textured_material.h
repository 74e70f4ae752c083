// A material as its file has it: of another colour wherever its texture or its vertices say so.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "scene/internal/texture.h"
#include "scene/mesh.h"

namespace pleinair {

struct TexturedMaterial {
  std::string name;
  // Times the colours of texture and vertices; both white where there are none.
  glm::vec3 base_colour{0.5f};
  // Share of a metal, which mirrors its colour and has no diffuse part; the rest has the colour for
  // its diffuse albedo and mirrors `dielectric_reflectance`.
  float metallic = 0.0f;
  glm::vec3 dielectric_reflectance{0.0f};
  float roughness = 1.0f;
  std::shared_ptr<const Texture> texture;  // Null: none.
  unsigned texture_set = 0;                // Which of a vertex' texture coordinates.

  // Where texture and vertices are of this colour together; within what interreflection that is to
  // converge allows.
  Material WithColour(const glm::vec3& colour) const;
  // Where they are of their means.
  Material Mean() const { return WithColour(texture ? texture->Mean() : glm::vec3(1.0f)); }
  // Whether WithColour has to limit it.
  bool ExceedsLimits() const;
};

// Makes a mesh's list of materials: one for each colour that is asked for.
class MaterialList {
 public:
  // Returns its number as a source.
  std::uint32_t Add(TexturedMaterial source) {
    sources_.push_back(std::move(source));
    return static_cast<std::uint32_t>(sources_.size() - 1);
  }
  const TexturedMaterial& Source(std::uint32_t source) const { return sources_[source]; }
  // Into Materials(). Colours are taken to the next of 128 steps of display code; white, and the
  // mean of a texture, are exact.
  std::uint32_t Index(std::uint32_t source, const glm::vec3& colour);

  const std::vector<Material>& Materials() const { return materials_; }

 private:
  std::vector<TexturedMaterial> sources_;
  std::vector<Material> materials_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> index_of_;
};

}  // namespace pleinair

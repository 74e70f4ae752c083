// Shares of the objects' vertices in each pixel of their layer. No OpenGL here.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "render/internal/sample_lattice.h"
#include "scene/mesh.h"

namespace pleinair {

struct TriangleByPlace {
  const TexturedMaterial* material = nullptr;
  TriangleColours colours;
};

// Light without the sun is interpolated between the vertices. So a pixel's mean over its samples is
// a sum over vertices, whose weights hold while neither the camera nor the objects move. New light
// then costs a few products for each pixel, independent of the number of samples. Where a texture
// gives each sample its colour, the weights are coloured.
class VertexShares {
 public:
  // The triangles that samples show, and where those lie.
  struct Samples {
    const SampleLattice& lattice;
    // 1 + triangle, 0 where none is; as wide as the lattice's picture, the top row first.
    std::span<const std::uint32_t> triangle;
    glm::mat4 clip_from_position{1.0f};  // To that picture.
    std::span<const glm::vec3> positions;
    std::span<const glm::uvec3> triangles;
    // The materials by place of the last triangles. `mirrors`: glossy ones without what they
    // mirror, which is then added.
    std::span<const TriangleByPlace> by_place{};
    bool mirrors = false;
  };

  // Weights are those of OpenGL's interpolation, perspective included. `is_glossy` is per vertex; a
  // triangle's vertices agree.
  VertexShares() = default;
  VertexShares(const Samples& samples, const std::vector<bool>& is_glossy);

  // Radiance times coverage, and coverage. `at_vertices` is radiance, of triangles by place that of
  // white ones; `mirrored`, empty or a value a pixel, is added to the share of a pixel that shows
  // what is glossy.
  void Sum(std::span<const glm::vec3> at_vertices,
           std::span<const glm::vec3> mirrored,
           std::vector<glm::vec4>& layer) const;

 private:
  struct Entry {
    std::uint32_t vertex = 0;
    float weight = 0.0f;
  };
  struct Pixel {
    std::uint32_t end = 0;  // End of its entries in the row; they begin at the last pixel's end.
    float coverage = 0.0f;
    float glossy = 0.0f;
  };
  struct ColouredEntry {
    std::uint32_t vertex = 0;
    glm::vec3 weight{0.0f};
  };
  struct Row {
    std::vector<Pixel> pixels;
    std::vector<Entry> entries;
    // By place; empty where the row shows none.
    std::vector<ColouredEntry> coloured;
    std::vector<std::uint32_t> coloured_end;  // A pixel.
  };

  std::vector<Row> rows_;
};

}  // namespace pleinair

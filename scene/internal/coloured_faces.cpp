#include "scene/internal/coloured_faces.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

constexpr double kTexelsOfAFace = 4.0;
constexpr double kVertexColoursOfAFace = 0.05;
constexpr int kMostCuts = 6;

LooseCorner Middle(const LooseCorner& a, const LooseCorner& b) {
  LooseCorner middle;
  middle.position_m = 0.5 * (a.position_m + b.position_m);
  middle.texture_uv = 0.5 * (a.texture_uv + b.texture_uv);
  middle.colour = 0.5f * (a.colour + b.colour);
  // Where one is missing the sum is no mean: it is to be made anew.
  const bool both = glm::dot(a.normal, a.normal) > 0.0f && glm::dot(b.normal, b.normal) > 0.0f;
  if (both) middle.normal = glm::normalize(a.normal) + glm::normalize(b.normal);
  return middle;
}

// How many times too long its longest edge is.
double Excess(const LooseTriangle& triangle, const TexturedMaterial& material) {
  double excess = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const LooseCorner& a = triangle.corners[c];
    const LooseCorner& b = triangle.corners[(c + 1) % 3];
    const glm::vec3 colours = glm::abs(b.colour - a.colour);
    excess = std::max(excess,
                      double{std::max({colours.r, colours.g, colours.b})} / kVertexColoursOfAFace);
    if (!material.texture) continue;
    const glm::dvec2 texels = (b.texture_uv - a.texture_uv) *
                              glm::dvec2(material.texture->Width(), material.texture->Height());
    excess = std::max(excess, glm::length(texels) / kTexelsOfAFace);
  }
  return std::isfinite(excess) ? excess : 0.0;
}

}  // namespace

int WorthwhileCuts(std::span<const LooseTriangle> triangles,
                   const MaterialList& sources,
                   std::size_t most) {
  double excess = 0.0;
  for (const LooseTriangle& triangle : triangles) {
    excess = std::max(excess, Excess(triangle, sources.Source(triangle.material)));
  }
  int cuts = 0;
  std::size_t count = triangles.size();
  while (cuts < kMostCuts && excess > 1.0 && 4 * count <= most) {
    ++cuts;
    count *= 4;
    excess /= 2.0;
  }
  return cuts;
}

std::vector<LooseTriangle> CutIntoFour(std::span<const LooseTriangle> triangles) {
  std::vector<LooseTriangle> cut;
  cut.reserve(4 * triangles.size());
  for (const LooseTriangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.corners;
    const LooseCorner ab = Middle(a, b);
    const LooseCorner bc = Middle(b, c);
    const LooseCorner ca = Middle(c, a);
    for (const std::array<LooseCorner, 3>& corners : {std::array{a, ab, ca},
                                                      std::array{ab, b, bc},
                                                      std::array{ca, bc, c},
                                                      std::array{ab, bc, ca}}) {
      cut.push_back({corners, triangle.material, triangle.group});
    }
  }
  return cut;
}

}  // namespace pleinair

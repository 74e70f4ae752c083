#include "scene/internal/mesh_normals.h"

#include <cmath>
#include <cstdint>

#include <glm/geometric.hpp>

#include "scene/angle_between.h"

namespace pleinair {
namespace {

// The cost is quadratic in a corner's triangles; past this many (the tip of a fine cone) the corner
// takes the triangle's own normal.
constexpr std::size_t kMaxTrianglesAround = 2048;

// Triangles around each position: `around[first[p]]` up to `around[first[p + 1]]`.
struct Neighbourhood {
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> around;
};

Neighbourhood NeighbourhoodOf(std::size_t positions, std::span<const glm::uvec3> triangles) {
  Neighbourhood result;
  result.first.assign(positions + 1, 0);
  for (const glm::uvec3& triangle : triangles) {
    for (int corner = 0; corner < 3; ++corner) ++result.first[triangle[corner] + 1];
  }
  for (std::size_t p = 0; p < positions; ++p) result.first[p + 1] += result.first[p];
  result.around.resize(triangles.size() * 3);
  std::vector<std::size_t> next(result.first.begin(), result.first.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      result.around[next[triangles[t][corner]]++] = static_cast<std::uint32_t>(t);
    }
  }
  return result;
}

}  // namespace

std::vector<std::array<glm::vec3, 3>> CornerNormals(std::span<const glm::vec3> positions,
                                                    std::span<const glm::uvec3> triangles) {
  std::vector<glm::dvec3> flat(triangles.size());
  std::vector<glm::dvec3> angles(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const glm::dvec3 a(positions[triangles[t].x]);
    const glm::dvec3 b(positions[triangles[t].y]);
    const glm::dvec3 c(positions[triangles[t].z]);
    flat[t] = glm::normalize(glm::cross(b - a, c - a));
    angles[t] = {AngleBetweenRad(b - a, c - a),
                 AngleBetweenRad(c - b, a - b),
                 AngleBetweenRad(a - c, b - c)};
  }
  const Neighbourhood neighbours = NeighbourhoodOf(positions.size(), triangles);
  const double smallest_cosine = std::cos(kCreaseAngleRad);

  std::vector<std::array<glm::vec3, 3>> normals(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t position = triangles[t][corner];
      const std::size_t begin = neighbours.first[position];
      const std::size_t end = neighbours.first[position + 1];
      glm::dvec3 sum(0.0);
      if (end - begin <= kMaxTrianglesAround) {
        // In the order of the triangles, so that corners with the same neighbours get the same bits
        // and weld.
        for (std::size_t i = begin; i < end; ++i) {
          const std::uint32_t other = neighbours.around[i];
          if (glm::dot(flat[t], flat[other]) < smallest_cosine) continue;
          for (int k = 0; k < 3; ++k) {
            if (triangles[other][k] == position) sum += angles[other][k] * flat[other];
          }
        }
      }
      const double length = glm::length(sum);
      normals[t][static_cast<std::size_t>(corner)] =
          glm::vec3(length > 0.0 ? sum / length : flat[t]);
    }
  }
  return normals;
}

}  // namespace pleinair

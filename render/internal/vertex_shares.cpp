#include "render/internal/vertex_shares.h"

#include <algorithm>
#include <array>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// Where a sample lies in a triangle: with the corners' clip coordinates (x, y, w) as columns of M,
// the weights are M^-1 (x, y, 1) up to their sum (Olano and Greer 1997, "Triangle scan conversion
// using 2D homogeneous coordinates"), also where a corner lies behind the camera.
class TriangleWeights {
 public:
  TriangleWeights(const VertexShares::Samples& samples, const glm::uvec3& triangle) {
    std::array<glm::dvec3, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const glm::vec4 clip =
          samples.clip_from_position * glm::vec4(samples.positions[triangle[k]], 1.0f);
      corner[static_cast<std::size_t>(k)] = glm::dvec3(clip.x, clip.y, clip.w);
    }
    // Of the inverse only the direction matters, and its sign goes with the sum's.
    rows_ = {glm::cross(corner[1], corner[2]),
             glm::cross(corner[2], corner[0]),
             glm::cross(corner[0], corner[1])};
  }

  glm::vec3 At(const glm::dvec2& clip) const {
    const glm::dvec3 sample(clip, 1.0);
    const glm::dvec3 weights(
        glm::dot(rows_[0], sample), glm::dot(rows_[1], sample), glm::dot(rows_[2], sample));
    const double sum = weights.x + weights.y + weights.z;
    // OpenGL moves corners by a part of a sample's width: a sample may lie just outside.
    const glm::dvec3 inside = glm::clamp(weights / sum, 0.0, 1.0);
    const double sum_inside = inside.x + inside.y + inside.z;
    if (!(sum_inside > 0.0)) return glm::vec3(1.0f / 3.0f);  // Seen from its very edge.
    return glm::vec3(inside / sum_inside);
  }

 private:
  std::array<glm::dvec3, 3> rows_;
};

}  // namespace

VertexShares::VertexShares(const Samples& samples, const std::vector<bool>& is_glossy)
    : rows_(static_cast<std::size_t>(samples.size_px.y)) {
  const int side = samples.per_side;
  const glm::dvec2 extent(side * samples.size_px);
  const float share = 1.0f / static_cast<float>(side * side);
  tbb::parallel_for(0, samples.size_px.y, [&](int y) {
    struct Seen {
      std::uint32_t number;
      TriangleWeights weights;
      int samples;
      glm::vec3 sum;
    };
    std::vector<Seen> seen;
    Row& row = rows_[static_cast<std::size_t>(y)];
    row.pixels.resize(static_cast<std::size_t>(samples.size_px.x));
    for (int x = 0; x < samples.size_px.x; ++x) {
      seen.clear();
      for (int v = side * y; v < side * (y + 1); ++v) {
        for (int u = side * x; u < side * (x + 1); ++u) {
          const std::uint32_t number =
              samples.triangle[static_cast<std::size_t>(v) *
                                   static_cast<std::size_t>(side * samples.size_px.x) +
                               static_cast<std::size_t>(u)];
          if (number == 0) continue;
          auto found = std::find_if(
              seen.begin(), seen.end(), [&](const Seen& s) { return s.number == number; });
          if (found == seen.end()) {
            seen.push_back({number,
                            TriangleWeights(samples, samples.triangles[number - 1]),
                            0,
                            glm::vec3(0.0f)});
            found = seen.end() - 1;
          }
          ++found->samples;
          found->sum += found->weights.At(2.0 * glm::dvec2(u + 0.5, v + 0.5) / extent - 1.0);
        }
      }
      Pixel& pixel = row.pixels[static_cast<std::size_t>(x)];
      const std::size_t begin = row.entries.size();
      for (const Seen& of : seen) {
        const glm::uvec3& triangle = samples.triangles[of.number - 1];
        const float covers = share * static_cast<float>(of.samples);
        pixel.coverage += covers;
        if (is_glossy[triangle.x]) pixel.glossy += covers;
        for (int k = 0; k < 3; ++k) {
          const auto first = row.entries.begin() + static_cast<std::ptrdiff_t>(begin);
          const auto found = std::find_if(
              first, row.entries.end(), [&](const Entry& e) { return e.vertex == triangle[k]; });
          if (found != row.entries.end()) {
            found->weight += share * of.sum[k];
          } else {
            row.entries.push_back({triangle[k], share * of.sum[k]});
          }
        }
      }
      pixel.end = static_cast<std::uint32_t>(row.entries.size());
    }
  });
}

void VertexShares::Sum(std::span<const glm::vec3> at_vertices,
                       std::span<const glm::vec3> mirrored,
                       std::vector<glm::vec4>& layer) const {
  const std::size_t width = rows_.empty() ? 0 : rows_.front().pixels.size();
  layer.resize(rows_.size() * width);
  tbb::parallel_for(std::size_t{0}, rows_.size(), [&](std::size_t y) {
    const Row& row = rows_[y];
    std::size_t entry = 0;
    for (std::size_t x = 0; x < width; ++x) {
      const Pixel& pixel = row.pixels[x];
      glm::vec3 sum(0.0f);
      for (; entry < pixel.end; ++entry) {
        sum += row.entries[entry].weight * at_vertices[row.entries[entry].vertex];
      }
      if (!mirrored.empty()) sum += pixel.glossy * mirrored[y * width + x];
      layer[y * width + x] = glm::vec4(sum, pixel.coverage);
    }
  });
}

}  // namespace pleinair

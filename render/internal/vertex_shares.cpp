#include "render/internal/vertex_shares.h"

#include <algorithm>
#include <array>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/textured_material.h"

namespace pleinair {
namespace {

// Barycentric weights of a sample in a triangle. With the corners' clip coordinates (x, y, w) as
// columns of M, they are M^-1 (x, y, 1) up to their sum, also where a corner lies behind the
// camera. Source: Olano and Greer 1997, "Triangle scan conversion using 2D homogeneous
// coordinates".
class TriangleWeights {
 public:
  TriangleWeights(const VertexShares::Samples& samples, const glm::uvec3& triangle) {
    std::array<glm::dvec3, 3> corner;
    for (int k = 0; k < 3; ++k) {
      const glm::vec4 clip =
          samples.clip_from_position * glm::vec4(samples.positions[triangle[k]], 1.0f);
      corner[static_cast<std::size_t>(k)] = glm::dvec3(clip.x, clip.y, clip.w);
    }
    // Only the direction of the inverse matters, and its sign goes with the sum's.
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

  // Change of the weights from one sample to the next, to the right and down: the derivative of n_k
  // / sum. Not finite where the triangle is seen from its edge.
  std::array<glm::vec3, 2> Steps(const glm::dvec2& clip, const glm::dvec2& clip_step) const {
    const glm::dvec3 sample(clip, 1.0);
    const glm::dvec3 weights(
        glm::dot(rows_[0], sample), glm::dot(rows_[1], sample), glm::dot(rows_[2], sample));
    const double sum = weights.x + weights.y + weights.z;
    const glm::dvec3 all = rows_[0] + rows_[1] + rows_[2];
    std::array<glm::vec3, 2> steps;
    for (int axis = 0; axis < 2; ++axis) {
      const glm::dvec3 of_rows(rows_[0][axis], rows_[1][axis], rows_[2][axis]);
      steps[static_cast<std::size_t>(axis)] =
          glm::vec3(clip_step[axis] / sum * (of_rows - all[axis] / sum * weights));
    }
    return steps;
  }

 private:
  std::array<glm::dvec3, 3> rows_;
};

// The albedo by which a sample's place reflects light from the vertices, as in the device's shader.
glm::vec3 AlbedoAt(const TriangleByPlace& triangle,
                   bool mirrors,
                   const glm::vec3& weights,
                   const std::array<glm::vec3, 2>& steps) {
  const TexturedMaterial& material = *triangle.material;
  const auto& uv = triangle.colours.texture_uv;
  const auto& vertex = triangle.colours.vertex_colour;
  const auto place = [&](const glm::vec3& w) { return w.x * uv[0] + w.y * uv[1] + w.z * uv[2]; };
  float level = 0.0f;
  if (material.texture) level = material.texture->LevelFor(place(steps[0]), place(steps[1]));
  const glm::vec4 of_vertices =
      weights.x * vertex[0] + weights.y * vertex[1] + weights.z * vertex[2];
  const TexturedMaterial::Reflectances here =
      material.Of(glm::vec3(material.ColourAt(place(weights), level, of_vertices)));
  return mirrors ? here.diffuse_albedo
                 : glm::min(here.diffuse_albedo + here.specular_reflectance, glm::vec3(1.0f));
}

// A triangle in a pixel.
struct SeenTriangle {
  std::uint32_t number;
  TriangleWeights weights;
  const TriangleByPlace* by_place;
  bool mirrors;
  int samples = 0;
  // Sum of weights; for materials by place, of weights times albedo.
  glm::vec3 sum{0.0f};
  std::array<glm::vec3, 3> coloured{glm::vec3(0.0f), glm::vec3(0.0f), glm::vec3(0.0f)};

  void Add(const glm::dvec2& clip, const glm::dvec2& clip_step) {
    ++samples;
    const glm::vec3 at = weights.At(clip);
    if (by_place == nullptr) {
      sum += at;
      return;
    }
    const glm::vec3 albedo = AlbedoAt(*by_place, mirrors, at, weights.Steps(clip, clip_step));
    for (int k = 0; k < 3; ++k) coloured[static_cast<std::size_t>(k)] += at[k] * albedo;
  }
};

// Adds to a pixel's entries, which are those from `begin` on.
template <typename Entry, typename Weight>
void AddShare(std::vector<Entry>& entries,
              std::size_t begin,
              std::uint32_t vertex,
              const Weight& weight) {
  const auto first = entries.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto found =
      std::find_if(first, entries.end(), [&](const Entry& e) { return e.vertex == vertex; });
  if (found != entries.end()) {
    found->weight += weight;
  } else {
    entries.push_back({vertex, weight});
  }
}

}  // namespace

VertexShares::VertexShares(const Samples& samples, const std::vector<bool>& is_glossy)
    : rows_(static_cast<std::size_t>(samples.lattice.Pixels().y)) {
  const SampleLattice& lattice = samples.lattice;
  const glm::ivec2 size_px = lattice.Pixels();
  const auto width = static_cast<std::size_t>(lattice.Size().x);
  const glm::dvec2 extent(lattice.Size());
  const float share = 1.0f / static_cast<float>(lattice.PerPixel());
  const std::size_t first_by_place = samples.triangles.size() - samples.by_place.size();
  tbb::parallel_for(0, size_px.y, [&](int y) {
    std::vector<SeenTriangle> seen;
    Row& row = rows_[static_cast<std::size_t>(y)];
    row.pixels.resize(static_cast<std::size_t>(size_px.x));
    for (int x = 0; x < size_px.x; ++x) {
      seen.clear();
      for (const glm::ivec2& offset : lattice.Offsets()) {
        const glm::ivec2 at = lattice.Of({x, y}) + offset;
        const std::uint32_t number =
            samples
                .triangle[static_cast<std::size_t>(at.y) * width + static_cast<std::size_t>(at.x)];
        if (number == 0) continue;
        auto found = std::find_if(
            seen.begin(), seen.end(), [&](const SeenTriangle& s) { return s.number == number; });
        if (found == seen.end()) {
          const std::size_t triangle = number - 1;
          const bool is_by_place = triangle >= first_by_place;
          seen.push_back({number,
                          TriangleWeights(samples, samples.triangles[triangle]),
                          is_by_place ? &samples.by_place[triangle - first_by_place] : nullptr,
                          samples.mirrors && is_glossy[samples.triangles[triangle].x]});
          found = seen.end() - 1;
        }
        found->Add(2.0 * (glm::dvec2(at) + 0.5) / extent - 1.0, 2.0 / extent);
      }
      Pixel& pixel = row.pixels[static_cast<std::size_t>(x)];
      const std::size_t begin = row.entries.size();
      const std::size_t begin_coloured = row.coloured.size();
      int covered = 0;
      int glossy = 0;
      for (const SeenTriangle& of : seen) {
        const glm::uvec3& triangle = samples.triangles[of.number - 1];
        covered += of.samples;
        if (is_glossy[triangle.x]) glossy += of.samples;
        for (int k = 0; k < 3; ++k) {
          if (of.by_place == nullptr) {
            AddShare(row.entries, begin, triangle[k], share * of.sum[k]);
          } else {
            AddShare(row.coloured,
                     begin_coloured,
                     triangle[k],
                     share * of.coloured[static_cast<std::size_t>(k)]);
          }
        }
      }
      const auto count = static_cast<float>(lattice.PerPixel());
      pixel.coverage = static_cast<float>(covered) / count;  // 1 for a fully covered pixel.
      pixel.glossy = static_cast<float>(glossy) / count;
      pixel.end = static_cast<std::uint32_t>(row.entries.size());
      if (!samples.by_place.empty()) {
        row.coloured_end.push_back(static_cast<std::uint32_t>(row.coloured.size()));
      }
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
    std::size_t coloured = 0;
    for (std::size_t x = 0; x < width; ++x) {
      const Pixel& pixel = row.pixels[x];
      glm::vec3 sum(0.0f);
      for (; entry < pixel.end; ++entry) {
        sum += row.entries[entry].weight * at_vertices[row.entries[entry].vertex];
      }
      for (; coloured < row.coloured.size() && coloured < row.coloured_end[x]; ++coloured) {
        sum += row.coloured[coloured].weight * at_vertices[row.coloured[coloured].vertex];
      }
      if (!mirrored.empty()) sum += pixel.glossy * mirrored[y * width + x];
      layer[y * width + x] = glm::vec4(sum, pixel.coverage);
    }
  });
}

}  // namespace pleinair

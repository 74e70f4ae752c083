#include "relight/transport/internal/smooth_normals.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>
#include <unordered_map>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

namespace pleinair::internal {
namespace {

constexpr int kPasses = 4;
// Normals farther apart than 60 deg are those of another surface. Noise of a tenth of an edge turns
// neighbours by some 20 deg from each other, an edge of a building by 90.
constexpr float kLeastCosine = 0.5f;
// Least area of a triangle over the mean around it. One with less is a sliver, and its own normal
// means nothing.
constexpr float kSliverShare = 0.1f;

// Which triangles have a corner at the same place.
class Neighbours {
 public:
  explicit Neighbours(const Mesh& mesh) : place_of_(mesh.triangles.size()) {
    std::unordered_map<glm::vec3, std::uint32_t, HashOfPosition> place_at;
    place_at.reserve(mesh.positions_m.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int corner = 0; corner < 3; ++corner) {
        // + 0: a zero is one, whatever its sign.
        const glm::vec3 position_m = mesh.positions_m[mesh.triangles[t][corner]] + 0.0f;
        const auto next = static_cast<std::uint32_t>(place_at.size());
        place_of_[t][static_cast<std::size_t>(corner)] =
            place_at.try_emplace(position_m, next).first->second;
      }
    }
    begin_.assign(place_at.size() + 1, 0);
    for (const Corners& corners : place_of_) {
      for (const std::uint32_t place : corners) ++begin_[place + 1];
    }
    for (std::size_t p = 0; p + 1 < begin_.size(); ++p) begin_[p + 1] += begin_[p];
    triangles_.resize(3 * place_of_.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t t = 0; t < place_of_.size(); ++t) {
      for (const std::uint32_t place : place_of_[t]) {
        triangles_[next[place]++] = static_cast<std::uint32_t>(t);
      }
    }
  }

  // visit(triangle): those around `triangle`, once a corner that they share, itself among them.
  template <class Visit>
  void ForEach(std::size_t triangle, const Visit& visit) const {
    for (const std::uint32_t place : place_of_[triangle]) {
      for (std::uint32_t k = begin_[place]; k < begin_[place + 1]; ++k) visit(triangles_[k]);
    }
  }

 private:
  using Corners = std::array<std::uint32_t, 3>;
  struct HashOfPosition {
    std::size_t operator()(const glm::vec3& at) const {
      std::uint64_t hash = 0;
      for (const float value : {at.x, at.y, at.z}) {
        hash = (hash ^ std::bit_cast<std::uint32_t>(value)) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
      }
      return hash;
    }
  };

  std::vector<Corners> place_of_;
  std::vector<std::uint32_t> begin_;
  std::vector<std::uint32_t> triangles_;
};

float AreaM2(const Mesh& mesh, std::size_t triangle) {
  const glm::uvec3& v = mesh.triangles[triangle];
  const glm::dvec3 a(mesh.positions_m[v.x]);
  return static_cast<float>(0.5 * glm::length(glm::cross(glm::dvec3(mesh.positions_m[v.y]) - a,
                                                         glm::dvec3(mesh.positions_m[v.z]) - a)));
}

}  // namespace

std::vector<glm::vec3> SmoothNormals(const Mesh& mesh, const std::vector<std::uint8_t>& is_small) {
  const std::size_t count = mesh.triangles.size();
  std::vector<glm::vec3> normals(count);
  std::vector<float> areas_m2(count);
  for (std::size_t t = 0; t < count; ++t) {
    normals[t] = TriangleNormal(mesh, static_cast<std::uint32_t>(t));
    areas_m2[t] = AreaM2(mesh, t);
  }
  const Neighbours neighbours(mesh);
  std::vector<glm::vec3> next(normals);
  const auto normal_of_sliver = [&](std::size_t t) {
    std::size_t largest = t;
    float sum_m2 = 0.0f;
    float visits = 0.0f;
    neighbours.ForEach(t, [&](std::size_t other) {
      sum_m2 += areas_m2[other];
      visits += 1.0f;
      if (areas_m2[other] > areas_m2[largest]) largest = other;
    });
    return areas_m2[t] * visits < kSliverShare * sum_m2 ? normals[largest] : normals[t];
  };
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t t) {
    if (is_small[t] != 0 && areas_m2[t] > 0.0f) next[t] = normal_of_sliver(t);
  });
  for (int pass = 0; pass < kPasses; ++pass) {
    normals.swap(next);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t t) {
      next[t] = normals[t];
      if (is_small[t] == 0 || areas_m2[t] == 0.0f) return;
      glm::vec3 sum(0.0f);
      neighbours.ForEach(t, [&](std::size_t other) {
        const float likeness = glm::dot(normals[t], normals[other]) - kLeastCosine;
        if (likeness > 0.0f) sum += likeness * areas_m2[other] * normals[other];
      });
      const float length = glm::length(sum);
      if (length > 0.0f) next[t] = sum / length;
    });
  }
  return next;
}

}  // namespace pleinair::internal

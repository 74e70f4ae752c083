#include "objects/internal/vertex_smoothing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <unordered_map>

#include <tbb/parallel_for.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// Normals farther apart than this are of another face; nearer ones count more.
constexpr float kLeastCosine = 0.97f;
// Shares of the hemisphere that objects hide count as alike within this, by the root of the rays
// that found them: a crevice is darker than what is beside it. It is 0.05 for 256 rays, which find
// a share to some 0.03.
constexpr float kShareSigmaOfOneRay = 0.8f;
// Slopes count as though so much more of the neighbours' weight had shown none.
constexpr float kNoSlopeShare = 0.05f;

// Vertices are doubled where faces of other colours or textures meet.
std::vector<std::uint32_t> PlaceOfVertex(const Mesh& mesh) {
  std::unordered_map<std::array<std::uint32_t, 3>, std::uint32_t, HashOfWords> number_of;
  std::vector<std::uint32_t> place_of_vertex;
  place_of_vertex.reserve(mesh.positions_m.size());
  for (const glm::vec3& position_m : mesh.positions_m) {
    std::array<std::uint32_t, 3> bits{};  // Of 0, where it is -0.
    for (int axis = 0; axis < 3; ++axis) {
      bits[static_cast<std::size_t>(axis)] = std::bit_cast<std::uint32_t>(position_m[axis] + 0.0f);
    }
    const auto number = static_cast<std::uint32_t>(number_of.size());
    place_of_vertex.push_back(number_of.try_emplace(bits, number).first->second);
  }
  return place_of_vertex;
}

void MakeUnique(std::vector<std::uint32_t>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

// Which vertices are where, and which places edges join.
class Neighbourhoods {
 public:
  Neighbourhoods(const Mesh& mesh, std::span<const float> hidden_share)
      : place_of_vertex_(PlaceOfVertex(mesh)),
        vertices_at_(mesh.positions_m.size()),
        beside_(mesh.positions_m.size()) {
    for (std::uint32_t v = 0; v < mesh.positions_m.size(); ++v) {
      if (hidden_share[v] < 1.0f) vertices_at_[place_of_vertex_[v]].push_back(v);
    }
    for (const glm::uvec3& triangle : mesh.triangles) {
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t place = place_of_vertex_[triangle[corner]];
        for (int step = 1; step < 3; ++step) {
          beside_[place].push_back(place_of_vertex_[triangle[(corner + step) % 3]]);
        }
      }
    }
    for (std::vector<std::uint32_t>& beside : beside_) MakeUnique(beside);
  }

  // At the places that one edge leads to, each place as one: calls visit(vertex, its part of 1).
  template <typename Visit>
  void ForBeside(std::size_t vertex, const Visit& visit) const {
    for (const std::uint32_t place : beside_[place_of_vertex_[vertex]]) {
      const std::vector<std::uint32_t>& there = vertices_at_[place];
      for (const std::uint32_t other : there) visit(other, 1.0f / static_cast<float>(there.size()));
    }
  }

  // At its own place, and those that one or two edges lead to.
  std::vector<std::uint32_t> Within2Edges(std::size_t vertex) const {
    constexpr std::size_t kMostBeside = 32;  // A fan's middle joins all of its rim.
    constexpr std::size_t kMostVertices = 256;
    const std::uint32_t own = place_of_vertex_[vertex];
    std::vector<std::uint32_t> places{own};
    for (const std::uint32_t place : beside_[own]) {
      places.push_back(place);
      if (beside_[place].size() > kMostBeside) continue;
      places.insert(places.end(), beside_[place].begin(), beside_[place].end());
    }
    MakeUnique(places);
    std::vector<std::uint32_t> vertices;
    for (const std::uint32_t place : places) {
      vertices.insert(vertices.end(), vertices_at_[place].begin(), vertices_at_[place].end());
      if (vertices.size() > kMostVertices) break;
    }
    return vertices;
  }

 private:
  std::vector<std::uint32_t> place_of_vertex_;
  std::vector<std::vector<std::uint32_t>> vertices_at_;  // By place; without hidden ones.
  std::vector<std::vector<std::uint32_t>> beside_;       // Places, by place.
};

}  // namespace

VertexSmoothing::VertexSmoothing(const Mesh& mesh, std::span<const float> hidden_share, int rays) {
  const float share_sigma = kShareSigmaOfOneRay / std::sqrt(static_cast<float>(rays));
  const Neighbourhoods around(mesh, hidden_share);
  std::vector<std::vector<Neighbour>> rows(mesh.positions_m.size());
  const auto fit = [&](std::size_t v) -> std::vector<Neighbour> {
    const glm::vec3& middle_m = mesh.positions_m[v];
    const glm::vec3& normal = mesh.normals[v];
    const glm::vec3 axis = std::abs(normal.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    const glm::vec3 across = glm::normalize(glm::cross(normal, axis));
    const glm::vec3 along = glm::cross(normal, across);
    // The weights' width: root mean square of the edges.
    float sum_m2 = 0.0f;
    float places = 0.0f;
    around.ForBeside(v, [&](std::uint32_t other, float part) {
      const glm::vec3 way_m = mesh.positions_m[other] - middle_m;
      sum_m2 += part * glm::dot(way_m, way_m);
      places += part;
    });
    if (!(sum_m2 > 0.0f)) return {};
    const float width_m = std::sqrt(sum_m2 / places);
    std::vector<Neighbour> row;
    std::vector<Eigen::Vector3f> terms;
    Eigen::Matrix3f information = Eigen::Matrix3f::Zero();
    for (const std::uint32_t other : around.Within2Edges(v)) {
      const float cosine = glm::dot(normal, mesh.normals[other]);
      if (!(cosine > kLeastCosine)) continue;
      const glm::vec3 way = (mesh.positions_m[other] - middle_m) / width_m;
      const float off = (hidden_share[other] - hidden_share[v]) / share_sigma;
      const float weight = (cosine - kLeastCosine) / (1.0f - kLeastCosine) *
                           std::exp(-0.5f * (glm::dot(way, way) + off * off));
      terms.emplace_back(1.0f, glm::dot(way, across), glm::dot(way, along));
      information += weight * terms.back() * terms.back().transpose();
      row.push_back({other, weight});
    }
    information.diagonal().tail<2>().array() += kNoSlopeShare * information(0, 0);
    const Eigen::Vector3f at_middle = information.ldlt().solve(Eigen::Vector3f::UnitX());
    if (row.size() < 2 || !at_middle.allFinite()) return {};
    for (std::size_t i = 0; i < row.size(); ++i) row[i].weight *= at_middle.dot(terms[i]);
    return row;
  };
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t v) {
    if (hidden_share[v] < 1.0f) rows[v] = fit(v);
  });
  first_.push_back(0);
  for (const std::vector<Neighbour>& row : rows) {
    neighbours_.insert(neighbours_.end(), row.begin(), row.end());
    first_.push_back(static_cast<std::uint32_t>(neighbours_.size()));
  }
}

std::vector<glm::vec3> VertexSmoothing::Smoothed(std::vector<glm::vec3> at_vertices) const {
  if (at_vertices.size() != VertexCount()) return at_vertices;
  std::vector<glm::vec3> smoothed = at_vertices;
  tbb::parallel_for(std::size_t{0}, at_vertices.size(), [&](std::size_t v) {
    if (first_[v] == first_[v + 1]) return;
    glm::vec3 sum(0.0f);
    for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
      sum += neighbours_[i].weight * at_vertices[neighbours_[i].vertex];
    }
    smoothed[v] = glm::max(sum, glm::vec3(0.0f));
  });
  return smoothed;
}

}  // namespace pleinair

#include "relight/transport/face_lattice.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair {
namespace {

// How far a receiver is drawn towards the middle of each small triangle around it.
constexpr float kInset = 0.15f;
// Sides whose normals agree to so much are of one plane.
constexpr float kNormalSteps = 512.0f;
// Places that are worked out from different triangles agree to float's rounding; 1/65536 m is more
// than that within 100 m.
constexpr double kPlaceSteps = 65536.0;

// Position and normal in steps.
struct PlaceKey {
  std::array<long long, 3> place;
  std::array<int, 3> normal;
  bool operator==(const PlaceKey&) const = default;
};

struct HashOfKey {
  std::size_t operator()(const PlaceKey& key) const {
    std::uint64_t hash = 0;
    const auto add = [&hash](long long value) {
      hash = (hash ^ static_cast<std::uint64_t>(value)) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    };
    for (const long long value : key.place) add(value);
    for (const int value : key.normal) add(value);
    return hash;
  }
};

PlaceKey KeyOf(const glm::vec3& position_m, const glm::vec3& normal) {
  const auto place = [](float value) { return std::llround(double{value} * kPlaceSteps); };
  const auto step = [](float value) { return static_cast<int>(std::lround(value * kNormalSteps)); };
  return {{place(position_m.x), place(position_m.y), place(position_m.z)},
          {step(normal.x), step(normal.y), step(normal.z)}};
}

// Slots of the rows before row r.
std::uint32_t RowBegin(std::uint32_t r) { return r * (r + 1) / 2; }

// Of a point in a triangle; one outside by rounding counts as on the edge. Patches have an area.
glm::vec3 BarycentricOf(const glm::vec3& point_m,
                        const glm::vec3& a_m,
                        const glm::vec3& b_m,
                        const glm::vec3& c_m) {
  const glm::vec3 normal = glm::cross(b_m - a_m, c_m - a_m);
  const float twice_area_squared = glm::dot(normal, normal);
  glm::vec3 weights(1.0f / 3.0f);
  if (!(twice_area_squared > 0.0f)) return weights;
  weights.x = glm::dot(normal, glm::cross(c_m - b_m, point_m - b_m)) / twice_area_squared;
  weights.y = glm::dot(normal, glm::cross(a_m - c_m, point_m - c_m)) / twice_area_squared;
  weights.z = 1.0f - weights.x - weights.y;
  weights = glm::max(weights, glm::vec3(0.0f));
  return weights / (weights.x + weights.y + weights.z);
}

}  // namespace

FaceLattice::FaceLattice(const PatchScene& scene, std::span<const std::uint16_t> parts)
    : parts_(parts.begin(), parts.end()) {
  if (parts.size() != scene.SideCount()) {
    throw std::invalid_argument(std::string("face lattice: parts has ") +
                                std::to_string(parts.size()) + " entries, expected " +
                                std::to_string(scene.SideCount()) + ", one a side");
  }
  std::unordered_map<PlaceKey, std::uint32_t, HashOfKey> receiver_at;
  std::vector<glm::dvec3> sum_m;  // Per receiver, over the small triangles around it.
  std::vector<int> triangles;
  for (std::size_t side = 0; side < parts_.size(); ++side) {
    first_slot_.push_back(static_cast<std::uint32_t>(receiver_of_slot_.size()));
    const std::uint32_t n = parts_[side];
    if (n == 0) continue;
    const glm::uvec3& vertices = scene.mesh.triangles[side / 2];
    const glm::vec3& a_m = scene.mesh.positions_m[vertices.x];
    const glm::vec3& b_m = scene.mesh.positions_m[vertices.y];
    const glm::vec3& c_m = scene.mesh.positions_m[vertices.z];
    const glm::vec3 normal = scene.SideNormal(side);
    const auto place_m = [&](std::uint32_t r, std::uint32_t i) {
      const auto at = [n](std::uint32_t k) {
        return static_cast<float>(k) / static_cast<float>(n);
      };
      return at(n - r) * a_m + at(r - i) * b_m + at(i) * c_m;
    };
    for (std::uint32_t r = 0; r <= n; ++r) {
      for (std::uint32_t i = 0; i <= r; ++i) {
        const glm::vec3 position_m = place_m(r, i);
        const auto next = static_cast<std::uint32_t>(receivers_.size());
        const std::uint32_t receiver =
            receiver_at.try_emplace(KeyOf(position_m, normal), next).first->second;
        if (receiver == next) {
          receivers_.push_back({position_m, normal});
          side_of_receiver_.push_back(static_cast<std::uint32_t>(side));
          sum_m.emplace_back(0.0);
          triangles.push_back(0);
        }
        receiver_of_slot_.push_back(receiver);
      }
    }
    const auto add_triangle = [&](std::array<glm::uvec2, 3> corners) {
      std::array<glm::vec3, 3> corners_m;
      glm::vec3 middle_m(0.0f);
      for (std::size_t k = 0; k < 3; ++k) {
        corners_m[k] = place_m(corners[k].x, corners[k].y);
        middle_m += corners_m[k] / 3.0f;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t receiver =
            receiver_of_slot_[first_slot_.back() + RowBegin(corners[k].x) + corners[k].y];
        sum_m[receiver] += glm::dvec3(corners_m[k] + kInset * (middle_m - corners_m[k]));
        ++triangles[receiver];
      }
    };
    for (std::uint32_t r = 0; r < n; ++r) {
      for (std::uint32_t i = 0; i <= r; ++i) {
        add_triangle({glm::uvec2(r, i), glm::uvec2(r + 1, i), glm::uvec2(r + 1, i + 1)});
        if (i < r) add_triangle({glm::uvec2(r, i), glm::uvec2(r, i + 1), glm::uvec2(r + 1, i + 1)});
      }
    }
  }
  for (std::size_t i = 0; i < receivers_.size(); ++i) {
    receivers_[i].position_m = glm::vec3(sum_m[i] / static_cast<double>(triangles[i]));
  }
}

std::array<FaceLattice::Weighted, 3> FaceLattice::Around(const PatchScene& scene,
                                                         std::size_t side,
                                                         const glm::vec3& point_m) const {
  const glm::uvec3& vertices = scene.mesh.triangles[side / 2];
  const glm::vec3 weights = BarycentricOf(point_m,
                                          scene.mesh.positions_m[vertices.x],
                                          scene.mesh.positions_m[vertices.y],
                                          scene.mesh.positions_m[vertices.z]);
  const std::uint32_t n = parts_[side];
  const auto most = static_cast<float>(n - 1);
  // Row and place in the row, as fractions: from vertex 0 downwards, and across.
  const float down = static_cast<float>(n) * (weights.y + weights.z);
  const float row = std::min(std::floor(down), most);
  const float across = std::min(static_cast<float>(n) * weights.z, down);
  const float column = std::min(std::floor(across), row);
  const float u = down - row;
  const float v = across - column;
  const auto r = static_cast<std::uint32_t>(row);
  const auto i = static_cast<std::uint32_t>(column);
  const auto receiver = [&](std::uint32_t slot_row, std::uint32_t place) {
    return receiver_of_slot_[first_slot_[side] + RowBegin(slot_row) + place];
  };
  const std::uint32_t top = receiver(r, i);
  const std::uint32_t far = receiver(r + 1, i + 1);
  if (v <= u || i == r) {
    const float held = std::min(v, u);
    return {Weighted{top, 1.0f - u}, {receiver(r + 1, i), u - held}, {far, held}};
  }
  return {Weighted{top, 1.0f - v}, {receiver(r, i + 1), v - u}, {far, u}};
}

}  // namespace pleinair

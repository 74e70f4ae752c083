#include "relight/transport/face_lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

// How far a receiver is drawn towards the middle of each small triangle around it.
constexpr float kInset = 0.15f;
// Sides whose normals agree to so much are of one plane.
constexpr float kNormalSteps = 512.0f;
// Places that are computed from different triangles agree to float's rounding; 1/65536 m is more
// than that within 100 m.
constexpr double kPlaceSteps = 65536.0;

// Less than any patch.
constexpr float kLeastExtentM = 1e-4f;

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
  std::size_t slots = 0;
  for (const std::uint16_t n : parts_) {
    if (n > 0) slots += (std::size_t{n} + 1) * (std::size_t{n} + 2) / 2;
  }
  receiver_of_slot_.reserve(slots);
  first_slot_.reserve(parts_.size());
  receiver_at.reserve(slots / 2);  // Most are shared.
  for (std::size_t side = 0; side < parts_.size(); ++side) {
    first_slot_.push_back(static_cast<std::uint32_t>(receiver_of_slot_.size()));
    const std::uint32_t n = parts_[side];
    if (n == 0 || scene.IsJoined(scene.PatchOf(side / 2))) continue;
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
  if (!scene.several.Empty()) AddGrids(scene);
}

// The receivers of grids' corners, by their place.
class FaceLattice::GridCorners {
 public:
  // The middle of a triangle that may be the receiver of a corner.
  struct Candidate {
    glm::vec3 position_m{0.0f};
    float apart_m = std::numeric_limits<float>::infinity();  // From the corner, along the grid.
  };

  GridCorners(std::vector<Receiver>& receivers, std::vector<std::uint32_t>& sides)
      : receivers_(receivers), sides_(sides), first_(receivers.size()) {}

  // The receiver of a corner, for which the candidate is the best of a face. It stands at the best
  // of all faces that have it.
  std::uint32_t At(const Grid& grid,
                   const std::array<std::int32_t, 2>& corner,
                   const Candidate& candidate,
                   const glm::vec3& normal,
                   std::size_t side) {
    const int axis = 3 - grid.across[0] - grid.across[1];
    const double height = candidate.position_m[axis];
    const Key key{2 * axis + (normal[axis] < 0.0f ? 1 : 0),
                  static_cast<std::int32_t>(std::lround(std::log2(grid.spacing_m))),
                  corner[0],
                  corner[1],
                  // Surfaces over each other have receivers of their own.
                  static_cast<std::int32_t>(
                      std::floor(height / (kLayerSpacings * grid.spacing_m) + kLayerOffset))};
    const auto next = static_cast<std::uint32_t>(receivers_.size());
    const std::uint32_t receiver = known_.try_emplace(key, next).first->second;
    if (receiver == next) {
      receivers_.emplace_back();
      sides_.emplace_back();
      apart_m_.push_back(std::numeric_limits<float>::infinity());
    }
    if (candidate.apart_m < apart_m_[receiver - first_]) {
      receivers_[receiver] = {candidate.position_m, normal};
      sides_[receiver] = static_cast<std::uint32_t>(side);
      apart_m_[receiver - first_] = candidate.apart_m;
    }
    return receiver;
  }

 private:
  static constexpr double kLayerSpacings = 2.0;
  // A plane through the origin would lie in two layers by its noise.
  static constexpr double kLayerOffset = 0.381966;

  using Key = std::array<std::int32_t, 5>;

  std::vector<Receiver>& receivers_;
  std::vector<std::uint32_t>& sides_;
  std::size_t first_;
  std::vector<float> apart_m_;
  std::unordered_map<Key, std::uint32_t, HashOfWords> known_;
};

FaceLattice::Grid FaceLattice::GridOver(const PatchScene& scene,
                                        std::size_t face,
                                        std::uint16_t parts) {
  const glm::vec3 size = glm::abs(scene.FaceNormal(face));
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  Grid grid;
  grid.across = {static_cast<std::uint8_t>((axis + 1) % 3),
                 static_cast<std::uint8_t>((axis + 2) % 3)};
  glm::vec2 lower_m(std::numeric_limits<float>::infinity());
  glm::vec2 upper_m(-std::numeric_limits<float>::infinity());
  const auto [begin, end] = scene.TrianglesOf(face / 2);
  for (std::size_t t = begin; t < end; ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec2 at_m = grid.Along(scene.mesh.positions_m[scene.mesh.triangles[t][corner]]);
      lower_m = glm::min(lower_m, at_m);
      upper_m = glm::max(upper_m, at_m);
    }
  }
  // A power of two, so that patches beside each other have the same corners.
  const float extent_m = std::max({upper_m.x - lower_m.x, upper_m.y - lower_m.y, kLeastExtentM});
  grid.spacing_m = std::exp2(std::floor(std::log2(extent_m / static_cast<float>(parts))));
  const glm::ivec2 first(glm::floor(lower_m / grid.spacing_m));
  const glm::ivec2 last = glm::ivec2(glm::floor(upper_m / grid.spacing_m)) + 1;
  grid.first = {first.x, first.y};
  grid.rows = static_cast<std::uint16_t>(last.x - first.x + 1);
  grid.columns = static_cast<std::uint16_t>(last.y - first.y + 1);
  return grid;
}

void FaceLattice::AddGrids(const PatchScene& scene) {
  grid_of_side_.assign(scene.SideCount(), kNoGrid);
  GridCorners corners(receivers_, side_of_receiver_);
  std::vector<GridCorners::Candidate> best;
  for (std::size_t face = 0; face < scene.FaceCount(); ++face) {
    if (!scene.IsJoined(face / 2)) continue;
    const auto [begin, end] = scene.TrianglesOf(face / 2);
    std::uint16_t parts = 0;
    for (std::size_t t = begin; t < end; ++t) parts = std::max(parts, parts_[2 * t + face % 2]);
    if (parts == 0) continue;
    Grid grid = GridOver(scene, face, parts);
    const auto corner_of = [&grid](std::size_t slot) -> std::array<std::int32_t, 2> {
      return {grid.first[0] + static_cast<std::int32_t>(slot / grid.columns),
              grid.first[1] + static_cast<std::int32_t>(slot % grid.columns)};
    };
    best.assign(grid.Corners(), {});
    for (std::size_t t = begin; t < end; ++t) {
      const glm::uvec3& v = scene.mesh.triangles[t];
      const glm::vec3 middle_m = (scene.mesh.positions_m[v.x] + scene.mesh.positions_m[v.y] +
                                  scene.mesh.positions_m[v.z]) /
                                 3.0f;
      for (std::size_t slot = 0; slot < best.size(); ++slot) {
        const auto [row, column] = corner_of(slot);
        const float apart_m =
            glm::distance(grid.spacing_m * glm::vec2(row, column), grid.Along(middle_m));
        if (apart_m < best[slot].apart_m) best[slot] = {middle_m, apart_m};
      }
    }
    grid.first_slot = static_cast<std::uint32_t>(receiver_of_slot_.size());
    const glm::vec3 normal = scene.FaceNormal(face);
    for (std::size_t slot = 0; slot < best.size(); ++slot) {
      receiver_of_slot_.push_back(
          corners.At(grid, corner_of(slot), best[slot], normal, 2 * begin + face % 2));
    }
    for (std::size_t t = begin; t < end; ++t) {
      parts_[2 * t + face % 2] = parts;
      grid_of_side_[2 * t + face % 2] = static_cast<std::uint32_t>(grids_.size());
    }
    grids_.push_back(grid);
  }
}

// Linear over each half of a square.
std::array<FaceLattice::Weighted, 3> FaceLattice::AroundOnGrid(const Grid& grid,
                                                               const glm::vec3& point_m) const {
  const glm::vec2 last(grid.rows - 1, grid.columns - 1);
  const glm::vec2 at =
      glm::clamp(grid.Along(point_m) / grid.spacing_m - glm::vec2(grid.first[0], grid.first[1]),
                 glm::vec2(0.0f),
                 last);
  const glm::vec2 corner = glm::min(glm::floor(at), last - 1.0f);
  const float u = at.x - corner.x;
  const float v = at.y - corner.y;
  const std::uint32_t first = grid.first_slot +
                              static_cast<std::uint32_t>(corner.x) * grid.columns +
                              static_cast<std::uint32_t>(corner.y);
  const std::uint32_t top = receiver_of_slot_[first];
  const std::uint32_t far = receiver_of_slot_[first + grid.columns + 1u];
  if (v <= u) {
    return {Weighted{top, 1.0f - u}, {receiver_of_slot_[first + grid.columns], u - v}, {far, v}};
  }
  return {Weighted{top, 1.0f - v}, {receiver_of_slot_[first + 1], v - u}, {far, u}};
}

// Patches have an area.
FaceLattice::Triangle FaceLattice::TriangleOf(const PatchScene& scene, std::size_t side) {
  const glm::uvec3& vertices = scene.mesh.triangles[side / 2];
  const glm::vec3& a_m = scene.mesh.positions_m[vertices.x];
  Triangle triangle;
  triangle.b_m = scene.mesh.positions_m[vertices.y];
  triangle.c_m = scene.mesh.positions_m[vertices.z];
  const glm::vec3 normal = glm::cross(triangle.b_m - a_m, triangle.c_m - a_m);
  const float twice_area_squared = glm::dot(normal, normal);
  triangle.has_area = twice_area_squared > 0.0f;
  if (!triangle.has_area) return triangle;
  triangle.of_a_per_m = glm::cross(normal, triangle.c_m - triangle.b_m) / twice_area_squared;
  triangle.of_b_per_m = glm::cross(normal, a_m - triangle.c_m) / twice_area_squared;
  return triangle;
}

void FaceLattice::LastSide::Take(std::size_t side) {
  side_ = side;
  grid_ = lattice_.GridOf(side);
  if (grid_ == nullptr) triangle_ = TriangleOf(scene_, side);
}

std::array<FaceLattice::Weighted, 3> FaceLattice::Around(const PatchScene& scene,
                                                         std::size_t side,
                                                         const glm::vec3& point_m) const {
  return LastSide(*this, scene).Around(side, point_m);
}

// A point outside by rounding counts as on the edge.
std::array<FaceLattice::Weighted, 3> FaceLattice::AroundInTriangle(std::size_t side,
                                                                   const Triangle& triangle,
                                                                   const glm::vec3& point_m) const {
  glm::vec3 weights(1.0f / 3.0f);
  if (triangle.has_area) {
    weights.x = glm::dot(triangle.of_a_per_m, point_m - triangle.b_m);
    weights.y = glm::dot(triangle.of_b_per_m, point_m - triangle.c_m);
    weights.z = 1.0f - weights.x - weights.y;
    weights = glm::max(weights, glm::vec3(0.0f));
    weights /= weights.x + weights.y + weights.z;
  }
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

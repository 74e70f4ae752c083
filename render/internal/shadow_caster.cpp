#include "render/internal/shadow_caster.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include <glm/geometric.hpp>

namespace pleinair {
namespace {

struct PositionKey {
  std::array<std::uint32_t, 3> bits{};
  bool operator==(const PositionKey&) const = default;
};

struct PositionHash {
  std::size_t operator()(const PositionKey& key) const {
    std::uint64_t hash = 0xcbf29ce484222325u;  // FNV-1a, a word at a time.
    for (const std::uint32_t word : key.bits) hash = (hash ^ word) * 0x100000001b3u;
    return static_cast<std::size_t>(hash ^ (hash >> 29));
  }
};

PositionKey KeyOf(const glm::vec3& position) {
  // Adding zero makes -0 and 0 one.
  return {{std::bit_cast<std::uint32_t>(position.x + 0.0f),
           std::bit_cast<std::uint32_t>(position.y + 0.0f),
           std::bit_cast<std::uint32_t>(position.z + 0.0f)}};
}

// The sun's plane: two axes across the beam.
struct BeamFrame {
  glm::dvec3 across_u;
  glm::dvec3 across_v;
  glm::dvec3 to_sun;
};

BeamFrame MakeBeamFrame(const glm::dvec3& to_sun) {
  const glm::dvec3 helper =
      std::abs(to_sun.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
  const glm::dvec3 across_u = glm::normalize(glm::cross(helper, to_sun));
  return {across_u, glm::cross(to_sun, across_u), to_sun};
}

struct BeamBox {
  double lower_u = std::numeric_limits<double>::infinity();
  double upper_u = -std::numeric_limits<double>::infinity();
  double lower_v = std::numeric_limits<double>::infinity();
  double upper_v = -std::numeric_limits<double>::infinity();
  double lower_height = std::numeric_limits<double>::infinity();  // Towards the sun.
  double upper_height = -std::numeric_limits<double>::infinity();

  void Add(const BeamFrame& frame, const glm::dvec3& point) {
    const double u = glm::dot(frame.across_u, point);
    const double v = glm::dot(frame.across_v, point);
    const double height = glm::dot(frame.to_sun, point);
    lower_u = std::min(lower_u, u);
    upper_u = std::max(upper_u, u);
    lower_v = std::min(lower_v, v);
    upper_v = std::max(upper_v, v);
    lower_height = std::min(lower_height, height);
    upper_height = std::max(upper_height, height);
  }
};

std::array<glm::dvec3, 8> CornersOf(const BoundingBox& box) {
  std::array<glm::dvec3, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners[static_cast<std::size_t>(i)] = {(i & 1) != 0 ? box.upper_m.x : box.lower_m.x,
                                            (i & 2) != 0 ? box.upper_m.y : box.lower_m.y,
                                            (i & 4) != 0 ? box.upper_m.z : box.lower_m.z};
  }
  return corners;
}

// How many triangles overlap each cell of a grid across the beam: a bound on how many prisms hold a
// point.
class OverlapGrid {
 public:
  OverlapGrid(const BeamBox& extent, std::size_t triangle_count)
      : side_(std::clamp(
            static_cast<int>(1.5 * std::sqrt(static_cast<double>(triangle_count))), 16, 256)),
        lower_u_(extent.lower_u),
        lower_v_(extent.lower_v),
        cells_per_u_(CellsPer(extent.upper_u - extent.lower_u)),
        cells_per_v_(CellsPer(extent.upper_v - extent.lower_v)),
        counts_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), 0) {}

  // Largest count among the cells that `box` touches.
  int DepthOver(const BeamBox& box) const {
    int depth = 0;
    ForCells(box, [&](std::size_t cell) { depth = std::max(depth, counts_[cell]); });
    return depth;
  }
  void Add(const BeamBox& box) {
    ForCells(box, [&](std::size_t cell) { ++counts_[cell]; });
  }
  void Clear() { std::fill(counts_.begin(), counts_.end(), 0); }

 private:
  double CellsPer(double length) const { return length > 0.0 ? side_ / length : 0.0; }
  int Cell(double offset, double cells_per) const {
    return std::clamp(static_cast<int>(offset * cells_per), 0, side_ - 1);
  }
  template <typename Function>
  void ForCells(const BeamBox& box, Function function) const {
    const int first_u = Cell(box.lower_u - lower_u_, cells_per_u_);
    const int last_u = Cell(box.upper_u - lower_u_, cells_per_u_);
    const int first_v = Cell(box.lower_v - lower_v_, cells_per_v_);
    const int last_v = Cell(box.upper_v - lower_v_, cells_per_v_);
    for (int v = first_v; v <= last_v; ++v) {
      for (int u = first_u; u <= last_u; ++u) {
        function(static_cast<std::size_t>(v) * static_cast<std::size_t>(side_) +
                 static_cast<std::size_t>(u));
      }
    }
  }

  int side_;
  double lower_u_;
  double lower_v_;
  double cells_per_u_;
  double cells_per_v_;
  std::vector<int> counts_;
};

}  // namespace

ShadowCaster::ShadowCaster(std::span<const glm::vec3> positions,
                           std::span<const glm::uvec3> triangles)
    : source_triangle_count_(triangles.size()) {
  std::unordered_map<PositionKey, std::uint32_t, PositionHash> joined;
  joined.reserve(positions.size());
  const auto join = [&](std::uint32_t vertex) {
    const glm::vec3& position = positions[vertex];
    const auto next = static_cast<std::uint32_t>(positions_.size());
    const auto [entry, is_new] = joined.try_emplace(KeyOf(position), next);
    if (is_new) positions_.push_back(position);
    return entry->second;
  };
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const glm::uvec3 corners(join(triangles[i].x), join(triangles[i].y), join(triangles[i].z));
    if (corners.x == corners.y || corners.y == corners.z || corners.z == corners.x) continue;
    const glm::dvec3 a(positions_[corners.x]);
    area_normals_.push_back(
        glm::cross(glm::dvec3(positions_[corners.y]) - a, glm::dvec3(positions_[corners.z]) - a));
    triangles_.push_back(corners);
    source_triangle_.push_back(static_cast<std::uint32_t>(i));
  }
  BuildEdges();
  ClassifyParts();
}

void ShadowCaster::BuildEdges() {
  struct Directed {
    std::uint64_t key = 0;
    EdgeUse use;
  };
  std::vector<Directed> directed;
  directed.reserve(3 * triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t from = triangles_[t][corner];
      const std::uint32_t to = triangles_[t][(corner + 1) % 3];
      const std::uint64_t lower = std::min(from, to);
      const std::uint64_t higher = std::max(from, to);
      directed.push_back(
          {(lower << 32) | higher, {static_cast<std::uint32_t>(t), from < to ? 1 : -1}});
    }
  }
  std::stable_sort(directed.begin(), directed.end(), [](const Directed& a, const Directed& b) {
    return a.key < b.key;
  });
  edge_uses_.reserve(directed.size());
  for (std::size_t i = 0; i < directed.size(); ++i) {
    if (i == 0 || directed[i].key != directed[i - 1].key) {
      edges_.push_back({static_cast<std::uint32_t>(directed[i].key >> 32),
                        static_cast<std::uint32_t>(directed[i].key),
                        static_cast<std::uint32_t>(i),
                        0});
    }
    ++edges_.back().use_count;
    edge_uses_.push_back(directed[i].use);
  }
}

// Parts are sets of triangles joined over edges. A part is closed where the directed edges of its
// triangles add up to zero; one that is inside out (a room, a cavity) has negative volume, and
// there it is the backs of its faces that stand for solid matter's outside.
void ShadowCaster::ClassifyParts() {
  std::vector<std::uint32_t> parent(triangles_.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root_of = [&](std::uint32_t triangle) {
    while (parent[triangle] != triangle) {
      parent[triangle] = parent[parent[triangle]];
      triangle = parent[triangle];
    }
    return triangle;
  };
  for (const Edge& edge : edges_) {
    const std::uint32_t first = edge_uses_[edge.first_use].triangle;
    for (std::uint32_t i = 1; i < edge.use_count; ++i) {
      parent[root_of(edge_uses_[edge.first_use + i].triangle)] = root_of(first);
    }
  }
  std::vector<std::uint8_t> is_open(triangles_.size(), 0);
  for (const Edge& edge : edges_) {
    std::int32_t sum = 0;
    for (std::uint32_t i = 0; i < edge.use_count; ++i) sum += edge_uses_[edge.first_use + i].sign;
    if (sum != 0) is_open[root_of(edge_uses_[edge.first_use].triangle)] = 1;
  }
  std::vector<double> volume(triangles_.size(), 0.0);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const std::uint32_t root = root_of(t);
    const glm::dvec3 apex(positions_[triangles_[root].x]);
    volume[root] += glm::dot(glm::dvec3(positions_[triangles_[t].x]) - apex, area_normals_[t]);
  }
  casting_.resize(triangles_.size());
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const std::uint32_t root = root_of(t);
    casting_[t] = is_open[root] != 0    ? Casting::kAllTurned
                  : volume[root] >= 0.0 ? Casting::kFrontToSun
                                        : Casting::kBackToSun;
  }
}

int ShadowCaster::FacingOf(std::size_t triangle, const glm::dvec3& to_sun) const {
  const double height = glm::dot(area_normals_[triangle], to_sun);
  return (height > 0.0) - (height < 0.0);
}

void ShadowCaster::Facing(const glm::dvec3& to_sun, std::vector<std::int8_t>& facing) const {
  facing.resize(triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    facing[t] = static_cast<std::int8_t>(FacingOf(t, to_sun));
  }
}

void ShadowCaster::FacingOfSourceTriangles(const glm::dvec3& to_sun,
                                           std::vector<std::int8_t>& facing) const {
  facing.assign(source_triangle_count_, 0);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    facing[source_triangle_[t]] = static_cast<std::int8_t>(FacingOf(t, to_sun));
  }
}

std::vector<std::int8_t> ShadowCaster::Weights(const glm::dvec3& to_sun,
                                               const std::optional<BoundingBox>& receivers) const {
  std::vector<std::int8_t> weights(triangles_.size(), 0);
  const BeamFrame frame = MakeBeamFrame(to_sun);
  BeamBox receiver_box;
  std::array<glm::dvec3, 8> receiver_corners{};
  if (receivers) {
    receiver_corners = CornersOf(*receivers);
    for (const glm::dvec3& corner : receiver_corners) receiver_box.Add(frame, corner);
  }
  const auto may_shade_receivers = [&](std::size_t t, int facing) {
    BeamBox box;
    for (int corner = 0; corner < 3; ++corner) {
      box.Add(frame, glm::dvec3(positions_[triangles_[t][corner]]));
    }
    if (box.lower_u > receiver_box.upper_u || box.upper_u < receiver_box.lower_u ||
        box.lower_v > receiver_box.upper_v || box.upper_v < receiver_box.lower_v ||
        box.upper_height < receiver_box.lower_height) {
      return false;
    }
    // All on the side of the triangle's plane that the sun is on?
    const glm::dvec3 corner(positions_[triangles_[t].x]);
    return std::any_of(
        receiver_corners.begin(), receiver_corners.end(), [&](const glm::dvec3& point) {
          return facing * glm::dot(area_normals_[t], point - corner) < 0.0;
        });
  };
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const int facing = FacingOf(t, to_sun);
    if (facing == 0) continue;  // Edge-on: its prism holds nothing.
    if (casting_[t] == Casting::kFrontToSun && facing < 0) continue;
    if (casting_[t] == Casting::kBackToSun && facing > 0) continue;
    if (receivers && !may_shade_receivers(t, facing)) continue;
    weights[t] = static_cast<std::int8_t>(facing);
  }
  return weights;
}

void ShadowCaster::AppendBatch(std::span<const std::int8_t> weights,
                               int depth_bound,
                               ShadowVolumes& volumes) const {
  ShadowVolumes::Batch batch;
  batch.first_cap = volumes.caps.size();
  batch.first_side = volumes.sides.size();
  batch.depth_bound = depth_bound;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (weights[t] == 0) continue;
    const glm::uvec3& corners = triangles_[t];
    volumes.caps.insert(volumes.caps.end(),
                        {corners.x,
                         weights[t] > 0 ? corners.y : corners.z,
                         weights[t] > 0 ? corners.z : corners.y});
  }
  for (const Edge& edge : edges_) {
    std::int32_t net = 0;
    for (std::uint32_t i = 0; i < edge.use_count; ++i) {
      const EdgeUse& use = edge_uses_[edge.first_use + i];
      net += use.sign * weights[use.triangle];
    }
    // A cap runs along the edge from `from` to `to`; the side that hangs on it runs back.
    const std::uint32_t from = net > 0 ? edge.lower : edge.higher;
    const std::uint32_t to = net > 0 ? edge.higher : edge.lower;
    for (std::int32_t i = 0; i < std::abs(net); ++i) {
      volumes.sides.insert(volumes.sides.end(), {to, from, InfinityIndex()});
    }
  }
  batch.cap_count = volumes.caps.size() - batch.first_cap;
  batch.side_count = volumes.sides.size() - batch.first_side;
  if (batch.cap_count > 0) volumes.batches.push_back(batch);
}

void ShadowCaster::BuildVolumes(const glm::dvec3& to_sun,
                                const std::optional<BoundingBox>& receivers,
                                ShadowVolumes& volumes) const {
  volumes.caps.clear();
  volumes.sides.clear();
  volumes.batches.clear();
  std::vector<std::int8_t> weights = Weights(to_sun, receivers);
  const auto casting_count = static_cast<std::size_t>(
      std::count_if(weights.begin(), weights.end(), [](std::int8_t w) { return w != 0; }));
  if (casting_count <= ShadowVolumes::kMaxBatchDepth) {
    AppendBatch(weights, static_cast<int>(casting_count), volumes);
    return;
  }
  const BeamFrame frame = MakeBeamFrame(to_sun);
  std::vector<BeamBox> boxes(triangles_.size());
  BeamBox extent;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (weights[t] == 0) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 point(positions_[triangles_[t][corner]]);
      boxes[t].Add(frame, point);
      extent.Add(frame, point);
    }
  }
  // Each round takes all triangles that still fit under the depth that a stencil can count.
  OverlapGrid grid(extent, casting_count);
  std::vector<std::int8_t> round(triangles_.size(), 0);
  bool is_left = true;
  while (is_left) {
    is_left = false;
    int depth_bound = 0;
    std::fill(round.begin(), round.end(), std::int8_t{0});
    grid.Clear();
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (weights[t] == 0) continue;
      const int depth = grid.DepthOver(boxes[t]) + 1;
      if (depth > ShadowVolumes::kMaxBatchDepth) {
        is_left = true;
        continue;
      }
      depth_bound = std::max(depth_bound, depth);
      grid.Add(boxes[t]);
      std::swap(round[t], weights[t]);
    }
    AppendBatch(round, depth_bound, volumes);
  }
}

}  // namespace pleinair

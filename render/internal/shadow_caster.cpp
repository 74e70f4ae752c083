#include "render/internal/shadow_caster.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "scene/disjoint_sets.h"

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

// In beam coordinates: x and y across the beam, z towards the sun.
struct BeamBox {
  glm::dvec3 lower{std::numeric_limits<double>::infinity()};
  glm::dvec3 upper{-std::numeric_limits<double>::infinity()};

  void Add(const glm::dvec3& point) {
    lower = glm::min(lower, point);
    upper = glm::max(upper, point);
  }
  bool OverlapsAcross(const BeamBox& other) const {
    return lower.x <= other.upper.x && other.lower.x <= upper.x && lower.y <= other.upper.y &&
           other.lower.y <= upper.y;
  }
};

// Number of triangles that overlap each cell of a grid across the beam: a bound on the number of
// prisms that contain a point.
class OverlapGrid {
 public:
  OverlapGrid(const BeamBox& extent, std::size_t triangle_count)
      : side_(std::clamp(
            static_cast<int>(3.0 * std::sqrt(static_cast<double>(triangle_count))), 16, 512)),
        lower_(extent.lower),
        cells_per_m_(CellsPer(extent.upper.x - extent.lower.x),
                     CellsPer(extent.upper.y - extent.lower.y)),
        counts_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), 0) {}

  // Adds a triangle and returns the largest count under it, or adds nothing and returns none where
  // that would exceed `max_depth`.
  std::optional<int> AddUpTo(const BeamBox& box, int max_depth) {
    const glm::ivec2 first = CellOf(box.lower);
    const glm::ivec2 last = CellOf(box.upper);
    int depth = 0;
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) depth = std::max<int>(depth, counts_[Index(x, y)]);
    }
    if (depth >= max_depth) return std::nullopt;
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) ++counts_[Index(x, y)];
    }
    return depth + 1;
  }
  void Clear() { std::fill(counts_.begin(), counts_.end(), std::uint8_t{0}); }

 private:
  double CellsPer(double length) const { return length > 0.0 ? side_ / length : 0.0; }
  glm::ivec2 CellOf(const glm::dvec3& point) const {
    return glm::clamp(glm::ivec2((glm::dvec2(point) - lower_) * cells_per_m_),
                      glm::ivec2(0),
                      glm::ivec2(side_ - 1));
  }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(x);
  }

  int side_;
  glm::dvec2 lower_;
  glm::dvec2 cells_per_m_;
  std::vector<std::uint8_t> counts_;  // Up to kMaxBatchDepth.
};

}  // namespace

// The caster as the sun sees it.
struct ShadowCaster::BeamView {
  BeamView(const ShadowCaster& caster, const glm::dvec3& direction_to_sun)
      : triangles(caster.triangles_), to_sun(direction_to_sun) {
    const glm::dvec3 helper =
        std::abs(to_sun.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
    across_x = glm::normalize(glm::cross(helper, to_sun));
    across_y = glm::cross(to_sun, across_x);
    positions.reserve(caster.positions_.size());
    for (const glm::vec3& position : caster.positions_) {
      positions.push_back(Transform(glm::dvec3(position)));
    }
  }
  glm::dvec3 Transform(const glm::dvec3& point) const {
    return {glm::dot(across_x, point), glm::dot(across_y, point), glm::dot(to_sun, point)};
  }
  BeamBox BoxOf(std::size_t triangle) const {
    BeamBox box;
    for (int corner = 0; corner < 3; ++corner) box.Add(positions[triangles[triangle][corner]]);
    return box;
  }

  std::span<const glm::uvec3> triangles;
  glm::dvec3 to_sun;
  glm::dvec3 across_x{0.0};
  glm::dvec3 across_y{0.0};
  std::vector<glm::dvec3> positions;  // In beam coordinates.
};

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

// Parts are sets of triangles joined over edges.
void ShadowCaster::FindParts() {
  part_.resize(triangles_.size());
  std::iota(part_.begin(), part_.end(), 0u);
  for (const Edge& edge : edges_) {
    const std::uint32_t first = edge_uses_[edge.first_use].triangle;
    for (std::uint32_t i = 1; i < edge.use_count; ++i) {
      part_[RootOf(part_, edge_uses_[edge.first_use + i].triangle)] = RootOf(part_, first);
    }
  }
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) part_[t] = RootOf(part_, t);
}

// Where the directed edges of a part do not add up to zero, they run along the rims of its holes.
// Rims that touch are one.
std::vector<ShadowCaster::Hole> ShadowCaster::FindHoles() const {
  struct RimEdge {
    std::uint32_t part = 0;
    std::uint32_t from = 0;  // As the cone's triangle runs: against the part's own.
    std::uint32_t to = 0;
    std::int32_t count = 0;
  };
  std::vector<RimEdge> rim_edges;
  std::vector<std::uint32_t> rim(positions_.size());
  std::iota(rim.begin(), rim.end(), 0u);
  for (const Edge& edge : edges_) {
    std::int32_t net = 0;
    for (std::uint32_t i = 0; i < edge.use_count; ++i) net += edge_uses_[edge.first_use + i].sign;
    if (net == 0) continue;
    rim_edges.push_back({part_[edge_uses_[edge.first_use].triangle],
                         net > 0 ? edge.higher : edge.lower,
                         net > 0 ? edge.lower : edge.higher,
                         std::abs(net)});
    rim[RootOf(rim, edge.lower)] = RootOf(rim, edge.higher);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<const RimEdge*>> by_hole;
  for (const RimEdge& edge : rim_edges) {
    by_hole[{edge.part, RootOf(rim, edge.from)}].push_back(&edge);
  }
  std::vector<Hole> holes;
  for (const auto& [key, edges] : by_hole) {
    Hole hole;
    hole.part = key.first;
    glm::dvec3 tip(0.0);
    for (const RimEdge* edge : edges) {
      hole.rim.emplace_back(positions_[edge->from]);
      hole.rim.emplace_back(positions_[edge->to]);
      tip += hole.rim[hole.rim.size() - 2] + hole.rim.back();
    }
    tip /= static_cast<double>(hole.rim.size());
    for (std::size_t i = 0; i < edges.size(); ++i) {
      hole.cone_area_normals.push_back(
          static_cast<double>(edges[i]->count) *
          glm::cross(hole.rim[2 * i] - tip, hole.rim[2 * i + 1] - tip));
    }
    hole.rim.push_back(tip);
    holes.push_back(std::move(hole));
  }
  return holes;
}

// A part that is inside out (a room, a cavity) has negative volume: there the backs of its faces
// are the outside of solid matter.
void ShadowCaster::ClassifyParts() {
  // Above this share of a part's area, holes are not holes: the part is a sheet.
  constexpr double kMaxHoleShare = 0.3;
  FindParts();
  std::vector<double> area(triangles_.size(), 0.0);
  std::vector<double> hole_area(triangles_.size(), 0.0);
  std::vector<double> volume(triangles_.size(), 0.0);
  const auto add_volume =
      [&](std::uint32_t part, const glm::dvec3& corner, const glm::dvec3& area_normal) {
        volume[part] += glm::dot(corner - glm::dvec3(positions_[triangles_[part].x]), area_normal);
      };
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    area[part_[t]] += glm::length(area_normals_[t]);
    add_volume(part_[t], glm::dvec3(positions_[triangles_[t].x]), area_normals_[t]);
  }
  for (Hole& hole : FindHoles()) {
    for (const glm::dvec3& area_normal : hole.cone_area_normals) {
      hole_area[hole.part] += glm::length(area_normal);
      add_volume(hole.part, hole.rim.back(), area_normal);
    }
    holes_.push_back(std::move(hole));
  }
  casting_of_part_.assign(triangles_.size(), Casting::kAllTurned);
  for (const std::uint32_t part : part_) {
    if (!(hole_area[part] <= kMaxHoleShare * area[part])) continue;
    casting_of_part_[part] = volume[part] >= 0.0 ? Casting::kFrontToSun : Casting::kBackToSun;
  }
  std::erase_if(
      holes_, [&](const Hole& hole) { return casting_of_part_[hole.part] == Casting::kAllTurned; });
}

int ShadowCaster::FacingOf(std::size_t triangle, const glm::dvec3& to_sun) const {
  const double height = glm::dot(area_normals_[triangle], to_sun);
  return (height > 0.0) - (height < 0.0);
}

void ShadowCaster::SidesThatMayBeSunlit(const glm::dvec3& to_sun,
                                        std::vector<std::int8_t>& sides) const {
  const std::vector<std::int8_t> weights = Weights(BeamView(*this, to_sun), std::nullopt);
  sides.assign(source_triangle_count_, 0);
  for (std::size_t t = 0; t < triangles_.size(); ++t) sides[source_triangle_[t]] = weights[t];
}

std::vector<std::int8_t> ShadowCaster::Weights(const BeamView& beam,
                                               const std::optional<BoundingBox>& receivers) const {
  struct OpenHole {
    std::uint32_t part = 0;
    BeamBox box;
  };
  std::vector<OpenHole> open_holes;
  for (const Hole& hole : holes_) {
    const double outwards = casting_of_part_[hole.part] == Casting::kFrontToSun ? 1.0 : -1.0;
    if (std::none_of(hole.cone_area_normals.begin(),
                     hole.cone_area_normals.end(),
                     [&](const glm::dvec3& normal) {
                       return outwards * glm::dot(normal, beam.to_sun) > 0.0;
                     })) {
      continue;
    }
    open_holes.push_back({hole.part, {}});
    for (const glm::dvec3& corner : hole.rim) open_holes.back().box.Add(beam.Transform(corner));
  }
  const auto casts = [&](std::size_t t, int facing) {
    const Casting casting = casting_of_part_[part_[t]];
    if (casting == Casting::kAllTurned) return true;
    if ((casting == Casting::kFrontToSun) == (facing > 0)) return true;
    return std::any_of(open_holes.begin(), open_holes.end(), [&](const OpenHole& hole) {
      return hole.part == part_[t] && hole.box.OverlapsAcross(beam.BoxOf(t));
    });
  };

  BeamBox receiver_box;
  std::array<glm::vec3, 8> receiver_corners{};
  if (receivers) {
    receiver_corners = CornersOf(*receivers);
    for (const glm::vec3& corner : receiver_corners)
      receiver_box.Add(beam.Transform(glm::dvec3(corner)));
  }
  const auto may_shade_receivers = [&](std::size_t t, int facing) {
    const BeamBox box = beam.BoxOf(t);
    if (!box.OverlapsAcross(receiver_box) || box.upper.z < receiver_box.lower.z) return false;
    // All on the side of the triangle's plane that the sun is on?
    const glm::dvec3 corner(positions_[triangles_[t].x]);
    return std::any_of(
        receiver_corners.begin(), receiver_corners.end(), [&](const glm::dvec3& point) {
          return facing * glm::dot(area_normals_[t], point - corner) < 0.0;
        });
  };
  std::vector<std::int8_t> weights(triangles_.size(), 0);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const int facing = FacingOf(t, beam.to_sun);
    if (facing == 0 || !casts(t, facing)) continue;  // Edge-on: its prism holds nothing.
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
    // A cap runs along the edge from `from` to `to`; the side attached to it runs back.
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
  const BeamView beam(*this, to_sun);
  std::vector<std::int8_t> weights = Weights(beam, receivers);
  BeamBox extent;
  std::size_t casting_count = 0;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (weights[t] == 0) continue;
    ++casting_count;
    const BeamBox box = beam.BoxOf(t);
    extent.Add(box.lower);
    extent.Add(box.upper);
  }
  if (casting_count <= ShadowVolumes::kMaxBatchDepth) {
    AppendBatch(weights, static_cast<int>(casting_count), volumes);
    return;
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
      const std::optional<int> depth = grid.AddUpTo(beam.BoxOf(t), ShadowVolumes::kMaxBatchDepth);
      if (!depth) {
        is_left = true;
        continue;
      }
      depth_bound = std::max(depth_bound, *depth);
      std::swap(round[t], weights[t]);
    }
    AppendBatch(round, depth_bound, volumes);
  }
}

}  // namespace pleinair

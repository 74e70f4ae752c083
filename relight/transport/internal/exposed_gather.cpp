#include "relight/transport/internal/exposed_gather.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/low_discrepancy.h"

namespace pleinair::internal {
namespace {

constexpr std::size_t kCells = FacePoints::kCells;
constexpr int kCellRows = 8;
static_assert(kCellRows * kCellRows == FacePoints::kCells);
// Rays that a cell tries for the sky. A cell that has open sky over a sixth of its hemisphere is
// missed by one in four; its neighbours' rays find it.
constexpr int kTriesForSky = 2;
// Share of a ray by which its end is stepped back: off the surface, and from a wall that stands on
// it, by more than rounding.
constexpr float kStepBack = 1e-4f;
constexpr float kShortOfCorner = 0.99f;

// The triangle cut into kCellRows rows along its barycentric axes: an upright and, but for the
// last of each row, a turned triangle at each step.
std::size_t CellOf(const glm::vec2& barycentric) {
  const float u = std::clamp(barycentric.x, 0.0f, 1.0f) * kCellRows;
  const float v = std::clamp(barycentric.y, 0.0f, 1.0f) * kCellRows;
  int row = std::min(static_cast<int>(u), kCellRows - 1);
  const int column = std::clamp(static_cast<int>(v), 0, kCellRows - 1 - row);
  const bool turned = (u - static_cast<float>(row)) + (v - static_cast<float>(column)) > 1.0f &&
                      column < kCellRows - 1 - row;
  // Row r begins after sum over s < r of (2 (rows - s) - 1) = r (2 rows - r) cells.
  return static_cast<std::size_t>(row * (2 * kCellRows - row) + 2 * column + (turned ? 1 : 0));
}

// A point of the cell for one of the unit square.
glm::vec2 PointInCell(std::size_t cell, glm::dvec2 point) {
  int row = 0;
  auto index = static_cast<int>(cell);
  while (index >= 2 * (kCellRows - row) - 1) index -= 2 * (kCellRows - row++) - 1;
  if (point.x + point.y > 1.0) point = glm::dvec2(1.0) - point;
  const int column = index / 2;
  const glm::dvec2 corner(row, column);
  const glm::dvec2 barycentric = index % 2 == 0 ? corner + point : corner + glm::dvec2(1.0) - point;
  return glm::vec2(barycentric / static_cast<double>(kCellRows));
}

struct FoundCell {
  std::size_t cell;  // Of the entire scene.
  glm::vec3 point_m;
};

class Search {
 public:
  Search(const PatchScene& scene, const GatherOptions& options)
      : scene_(scene),
        seed_(options.seed),
        rays_((options.rays_per_receiver + FacePoints::kCells - 1) / FacePoints::kCells),
        slot_(scene.FaceCount() * kCells, kNone) {}

  ExposedRays Run() {
    std::vector<FoundCell> wave = CellsThatSeeTheSky();
    while (!wave.empty()) wave = Shoot(wave);
    return InFaceOrder();
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::vector<FoundCell> CellsThatSeeTheSky() {
    std::vector<glm::vec3> point_m(slot_.size());
    std::vector<std::uint8_t> sees(slot_.size(), 0);
    tbb::parallel_for(std::size_t{0}, scene_.FaceCount(), [&](std::size_t face) {
      const glm::vec3 normal = scene_.FaceNormal(face);
      if (normal == glm::vec3(0.0f)) return;
      const glm::uvec3& v = scene_.mesh.triangles[face / 2];
      const glm::vec3 a = scene_.mesh.positions_m[v[0]];
      const NormalFrame frame(normal);
      const glm::dvec2 rotation = RotationOf(HashBits(seed_), face);
      for (std::size_t cell = 0; cell < kCells; ++cell) {
        for (int k = 0; k < kTriesForSky && sees[face * kCells + cell] == 0; ++k) {
          const int index = static_cast<int>(cell) + FacePoints::kCells * k;
          const glm::vec3 direction = frame.CosineDirection(
              FibonacciPoint(index, FacePoints::kCells * kTriesForSky, rotation));
          if (!(direction.z > 0.0f)) continue;
          const glm::vec2 weights = PointInCell(cell, R2Point(index, {rotation.y, rotation.x}));
          const glm::vec3 point = a + weights.x * (scene_.mesh.positions_m[v[1]] - a) +
                                  weights.y * (scene_.mesh.positions_m[v[2]] - a);
          const glm::vec3 origin = OffsetFromSurface(point, normal);
          if (scene_.caster.Occluded(origin, direction)) continue;
          sees[face * kCells + cell] = 1;
          point_m[face * kCells + cell] = origin;
        }
      }
    });
    std::vector<FoundCell> found;
    for (std::size_t cell = 0; cell < slot_.size(); ++cell) {
      if (sees[cell] != 0) Keep({cell, point_m[cell]}, found);
    }
    return found;
  }

  void Keep(const FoundCell& cell, std::vector<FoundCell>& wave) {
    if (slot_[cell.cell] != kNone) return;
    slot_[cell.cell] = static_cast<std::uint32_t>(points_.size());
    points_.push_back(cell.point_m);
    wave.push_back(cell);
  }

  // The point of a hit, on the side that the ray came from, clear of the surface by no less than
  // rounding.
  glm::vec3 StepBack(const RayHit& hit, const glm::vec3& direction, std::size_t face) const {
    return OffsetFromSurface(hit.position_m - (kStepBack * hit.distance_m) * direction,
                             scene_.FaceNormal(face));
  }

  // Casts the rays of a wave's points and returns the cells that they are the first to meet.
  std::vector<FoundCell> Shoot(const std::vector<FoundCell>& wave) {
    const auto rays = static_cast<std::size_t>(rays_);
    const std::size_t first_slot = points_.size() - wave.size();
    source_.resize(points_.size() * rays);
    direction_.resize(points_.size() * rays);
    std::vector<std::vector<FoundCell>> met(wave.size());
    tbb::parallel_for(std::size_t{0}, wave.size(), [&](std::size_t w) {
      const std::size_t face = wave[w].cell / kCells;
      const std::size_t cell = wave[w].cell % kCells;
      const NormalFrame frame(scene_.FaceNormal(face));
      const glm::dvec2 rotation = RotationOf(seed_, face);
      // Which of the face's directions are the cell's: neighbours' lie far apart, and no part of
      // all faces looks one way. (Odd times anything, modulo a power of two, is a permutation.)
      const int turn = static_cast<int>((cell * 37 + HashBits(face)) % kCells);
      for (int k = 0; k < rays_; ++k) {
        const glm::vec3 direction = frame.CosineDirection(
            FibonacciPoint(turn + FacePoints::kCells * k, FacePoints::kCells * rays_, rotation));
        const std::size_t ray = (first_slot + w) * rays + static_cast<std::size_t>(k);
        direction_[ray] = direction;
        const auto hit = scene_.caster.Intersect(wave[w].point_m, direction);
        if (!hit) {
          source_[ray] = direction.z > 0.0f ? ExposedRays::kSky : ExposedRays::kDark;
          continue;
        }
        source_[ray] = scene_.FaceOfHit(*hit, direction);
        const auto met_face = static_cast<std::size_t>(source_[ray]);
        const std::size_t met_cell = met_face * kCells + CellOf(hit->barycentric);
        if (slot_[met_cell] == kNone) {
          met[w].push_back({met_cell, StepBack(*hit, direction, met_face)});
        }
      }
    });
    std::vector<FoundCell> next;
    for (const std::vector<FoundCell>& of_point : met) {
      for (const FoundCell& cell : of_point) Keep(cell, next);
    }
    return next;
  }

  // Whether each cell's corners can be seen from its point. Where a wall crosses a cell, the part
  // of it behind the wall can't.
  bool IsWhole(std::size_t face) const {
    const glm::uvec3& v = scene_.mesh.triangles[face / 2];
    const glm::vec3 a = scene_.mesh.positions_m[v[0]];
    const glm::vec3 ab = scene_.mesh.positions_m[v[1]] - a;
    const glm::vec3 ac = scene_.mesh.positions_m[v[2]] - a;
    const glm::vec3 normal = scene_.FaceNormal(face);
    for (std::size_t cell = 0; cell < kCells; ++cell) {
      if (slot_[face * kCells + cell] == kNone) return false;
      const glm::vec3 point = points_[slot_[face * kCells + cell]];
      for (const glm::dvec2& corner :
           {glm::dvec2(0.0), glm::dvec2(1.0, 0.0), glm::dvec2(0.0, 1.0)}) {
        const glm::vec2 weights = PointInCell(cell, corner);
        const glm::vec3 end = OffsetFromSurface(a + weights.x * ab + weights.y * ac, normal);
        const float length = glm::distance(point, end);
        // A wall that begins at the corner is none of the cell's.
        if (length > 0.0f &&
            scene_.caster.Occluded(point, (end - point) / length, kShortOfCorner * length)) {
          return false;
        }
      }
    }
    return true;
  }

  ExposedRays InFaceOrder() const {
    const auto rays = static_cast<std::size_t>(rays_);
    ExposedRays exposed;
    exposed.rays_per_point = rays_;
    exposed.points.whole.resize(scene_.FaceCount());
    tbb::parallel_for(std::size_t{0}, scene_.FaceCount(), [&](std::size_t face) {
      exposed.points.whole[face] = IsWhole(face) ? 1 : 0;
    });
    exposed.points.begin.assign(1, 0);
    exposed.sky_begin.assign(1, 0);
    exposed.source.reserve(source_.size());
    for (std::size_t cell = 0; cell < slot_.size(); ++cell) {
      if (slot_[cell] != kNone) {
        exposed.points.position_m.push_back(points_[slot_[cell]]);
        for (std::size_t ray = slot_[cell] * rays; ray < (slot_[cell] + 1) * rays; ++ray) {
          exposed.source.push_back(source_[ray]);
          if (source_[ray] == ExposedRays::kSky) exposed.sky_direction.push_back(direction_[ray]);
        }
        exposed.sky_begin.push_back(exposed.sky_direction.size());
      }
      if (cell % kCells == kCells - 1) {
        exposed.points.begin.push_back(
            static_cast<std::uint32_t>(exposed.points.position_m.size()));
      }
    }
    return exposed;
  }

  const PatchScene& scene_;
  std::uint64_t seed_;
  int rays_;
  std::vector<std::uint32_t> slot_;  // Per cell of the scene: its place in points_.
  std::vector<glm::vec3> points_;    // In the order in which they were found.
  std::vector<std::int32_t> source_;
  std::vector<glm::vec3> direction_;
};

}  // namespace

ExposedRays GatherFromExposedFaces(const PatchScene& scene, const GatherOptions& options) {
  return Search(scene, options).Run();
}

}  // namespace pleinair::internal

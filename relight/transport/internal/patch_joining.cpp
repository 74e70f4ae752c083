#include "relight/transport/internal/patch_joining.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_map>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair::internal {
namespace {

// Longest edge of a triangle that is joined, as a share of the longest edge allowed. Patches of one
// triangle each have edges between half of that and all of it.
constexpr double kSmallShare = 0.7;
// Side of a cell over the longest edge allowed, to a factor of the root of two: a cell's area is
// then about that of patches that are cut.
constexpr double kCellShare = 0.5;
// Least area of a patch of its own, as a share of that of the cell's largest patch. Slivers of a
// noisy mesh look along all axes.
constexpr double kLeastAreaShare = 1.0 / 16.0;
// A plane through the origin would lie on the border of two cells, and its noise in both.
constexpr double kGridOffset = 0.381966;

struct CellKey {
  std::array<std::int32_t, 3> cell;
  std::int32_t level;
  std::uint32_t group;
  std::uint32_t material;
  bool is_made;
  bool operator==(const CellKey&) const = default;
};

struct HashOfKey {
  std::size_t operator()(const CellKey& key) const {
    std::uint64_t hash = key.is_made ? 1 : 0;
    const auto add = [&hash](std::uint32_t value) {
      hash = (hash ^ value) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    };
    for (const std::int32_t value : key.cell) add(static_cast<std::uint32_t>(value));
    add(static_cast<std::uint32_t>(key.level));
    add(key.group);
    add(key.material);
    return hash;
  }
};

// The axes with their signs.
constexpr std::size_t kAxes = 6;

// Which one a direction is nearest to.
std::size_t AxisOf(const glm::vec3& direction) {
  const glm::vec3 size = glm::abs(direction);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return static_cast<std::size_t>(2 * axis + (direction[axis] < 0.0f ? 1 : 0));
}

// The parts of a cell that look along each axis.
struct Cell {
  static constexpr std::uint32_t kNoPatch = 0xffffffffu;
  std::array<float, kAxes> area_m2{};
  std::array<std::uint32_t, kAxes> patch{
      kNoPatch, kNoPatch, kNoPatch, kNoPatch, kNoPatch, kNoPatch};

  // The axis whose patch has the part that looks along `axis`.
  std::size_t PatchAxis(std::size_t axis) const {
    const auto largest = std::max_element(area_m2.begin(), area_m2.end());
    return area_m2[axis] < kLeastAreaShare * *largest
               ? static_cast<std::size_t>(largest - area_m2.begin())
               : axis;
  }
};

class Joining {
 public:
  Joining(const TargetLength& target, std::uint32_t made, RefinedMesh& refined)
      : target_(target), made_(made), refined_(refined), mesh_(refined.mesh) {}

  PatchesOfTriangles Run() {
    const std::size_t count = mesh_.triangles.size();
    FindCells();
    PatchesOfTriangles patches;
    patches.of_triangle.resize(count);
    std::uint32_t next = 0;
    for (std::size_t t = 0; t < count; ++t) {
      std::uint32_t patch = next;
      if (cell_of_[t] != kAlone) {
        Cell& cell = cells_[cell_of_[t]];
        std::uint32_t& known = cell.patch[cell.PatchAxis(axis_of_[t])];
        if (known == Cell::kNoPatch) known = next;
        patch = known;
      }
      patches.of_triangle[t] = patch;
      if (patch == next) ++next;
    }
    if (next == count) return {};
    patches.begin.assign(next + 1, 0);
    for (const std::uint32_t patch : patches.of_triangle) ++patches.begin[patch + 1];
    for (std::size_t p = 0; p < next; ++p) patches.begin[p + 1] += patches.begin[p];
    BringInOrder(patches);
    AddAreas(patches);
    return patches;
  }

 private:
  static constexpr std::uint32_t kAlone = 0xffffffffu;

  void FindCells() {
    const std::size_t count = mesh_.triangles.size();
    cell_of_.assign(count, kAlone);
    axis_of_.resize(count);
    std::unordered_map<CellKey, std::uint32_t, HashOfKey> index_of;
    for (std::size_t t = 0; t < count; ++t) {
      const std::optional<CellKey> key = KeyOf(t);
      if (!key) continue;
      const auto next = static_cast<std::uint32_t>(cells_.size());
      cell_of_[t] = index_of.try_emplace(*key, next).first->second;
      if (cell_of_[t] == next) cells_.emplace_back();
      const glm::vec3 twice_area = TwiceArea(t);
      const std::size_t axis = AxisOf(twice_area);
      axis_of_[t] = static_cast<std::uint8_t>(axis);
      cells_[cell_of_[t]].area_m2[axis] += 0.5f * glm::length(twice_area);
    }
  }

  // Along the normal.
  glm::dvec3 TwiceArea(std::size_t t) const {
    const glm::uvec3& v = mesh_.triangles[t];
    const glm::dvec3 a(mesh_.positions_m[v.x]);
    return glm::cross(glm::dvec3(mesh_.positions_m[v.y]) - a,
                      glm::dvec3(mesh_.positions_m[v.z]) - a);
  }

  bool WasCut(std::size_t t) const {
    const std::vector<std::uint32_t>& source = refined_.source_triangle;
    return (t > 0 && source[t - 1] == source[t]) ||
           (t + 1 < source.size() && source[t + 1] == source[t]);
  }

  // None for a triangle that stays alone.
  std::optional<CellKey> KeyOf(std::size_t t) const {
    if (WasCut(t)) return std::nullopt;
    const glm::uvec3& v = mesh_.triangles[t];
    const glm::vec3& a = mesh_.positions_m[v.x];
    const glm::vec3& b = mesh_.positions_m[v.y];
    const glm::vec3& c = mesh_.positions_m[v.z];
    const glm::vec3 middle_m = (a + b + c) / 3.0f;
    const double longest_m = target_(middle_m);
    if (std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)}) >
        kSmallShare * longest_m) {
      return std::nullopt;
    }
    const int level = static_cast<int>(std::lround(std::log2(longest_m)));
    const double side_m = std::ldexp(kCellShare, level);
    CellKey key;
    for (int axis = 0; axis < 3; ++axis) {
      key.cell[static_cast<std::size_t>(axis)] =
          static_cast<std::int32_t>(std::floor(double{middle_m[axis]} / side_m + kGridOffset));
    }
    key.level = level;
    key.group = mesh_.triangle_group[t];
    key.material = mesh_.triangle_material[t];
    key.is_made = refined_.source_triangle[t] >= made_;
    return key;
  }

  void BringInOrder(PatchesOfTriangles& patches) {
    std::vector<std::uint32_t> next(patches.begin.begin(), patches.begin.end() - 1);
    std::vector<std::uint32_t> from(patches.of_triangle.size());
    for (std::size_t t = 0; t < from.size(); ++t) {
      from[next[patches.of_triangle[t]]++] = static_cast<std::uint32_t>(t);
    }
    const auto bring = [&from](auto& values) {
      if (values.empty()) return;
      auto ordered = values;
      for (std::size_t i = 0; i < from.size(); ++i) ordered[i] = values[from[i]];
      values = std::move(ordered);
    };
    bring(patches.of_triangle);
    bring(mesh_.triangles);
    bring(mesh_.triangle_material);
    bring(mesh_.triangle_group);
    bring(mesh_.triangle_colours);
    bring(refined_.source_triangle);
  }

  void AddAreas(PatchesOfTriangles& patches) const {
    patches.area_share_until.resize(patches.of_triangle.size());
    for (std::size_t p = 0; p < patches.Count(); ++p) {
      glm::dvec3 sum(0.0);
      std::vector<double> until;
      double area_m2 = 0.0;
      for (std::size_t t = patches.begin[p]; t < patches.begin[p + 1]; ++t) {
        const glm::dvec3 half = 0.5 * TwiceArea(t);
        sum += half;
        area_m2 += glm::length(half);
        until.push_back(area_m2);
      }
      for (std::size_t k = 0; k < until.size(); ++k) {
        patches.area_share_until[patches.begin[p] + k] = static_cast<float>(until[k] / area_m2);
      }
      patches.area_m2.push_back(static_cast<float>(area_m2));
      patches.normal.emplace_back(glm::normalize(sum));
    }
  }

  const TargetLength& target_;
  std::uint32_t made_;
  RefinedMesh& refined_;
  Mesh& mesh_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> cell_of_;  // Per triangle.
  std::vector<std::uint8_t> axis_of_;
};

}  // namespace

PatchesOfTriangles JoinSmallTriangles(const TargetLength& target,
                                      std::uint32_t made,
                                      RefinedMesh& refined) {
  return Joining(target, made, refined).Run();
}

}  // namespace pleinair::internal

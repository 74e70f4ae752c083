#include "relight/volume/internal/probe_stand.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace pleinair::internal {
namespace {

// Share of the spacing between probes: far below what interpolation between them resolves.
constexpr float kHair = 1e-3f;

// That distance is at least this share of the largest coordinate: 40 float roundings of a hit
// point.
constexpr float kLeastHairOfCoordinate = 5e-6f;

constexpr float kMostBackShare = 0.5f;

// More sky than this shows through no crack between a house's walls and the ground.
constexpr float kOpenSkyShare = 0.05f;

// Half of the 26 directions to the faces, edges and corners of a cube. The normal of any plane is
// within 28 deg of one of them or its opposite.
std::array<glm::vec3, 13> ProbingDirections() {
  std::array<glm::vec3, 13> directions;
  for (int i = 0; i < 13; ++i) {
    const int code = i + 14;  // 13 stands for (0, 0, 0); those beyond it are the opposite half.
    directions[static_cast<std::size_t>(i)] =
        glm::normalize(glm::vec3(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1));
  }
  return directions;
}

float HairOf(const glm::vec3& position_m, float spacing_m) {
  const float largest_m =
      std::max({std::abs(position_m.x), std::abs(position_m.y), std::abs(position_m.z)});
  return std::max(kHair * spacing_m, kLeastHairOfCoordinate * largest_m);
}

// Normals, by winding, of the surfaces within `hair_m`; one of each orientation.
std::vector<glm::vec3> TouchingNormals(const RayCaster& caster,
                                       const glm::vec3& position_m,
                                       float hair_m) {
  constexpr float kSameOrientation = 0.9f;
  std::vector<glm::vec3> normals;
  for (const glm::vec3& direction : ProbingDirections()) {
    const auto hit = caster.Intersect(position_m - hair_m * direction, direction, 2.0f * hair_m);
    if (!hit) continue;
    const bool known = std::any_of(normals.begin(), normals.end(), [&](const glm::vec3& normal) {
      return glm::dot(normal, hit->geometric_normal) > kSameOrientation;
    });
    if (!known) normals.push_back(hit->geometric_normal);
  }
  return normals;
}

}  // namespace

std::vector<glm::vec3> ClearStands(const RayCaster& caster,
                                   const glm::vec3& position_m,
                                   float spacing_m) {
  const float hair_m = HairOf(position_m, spacing_m);
  const std::vector<glm::vec3> normals = TouchingNormals(caster, position_m, hair_m);
  if (normals.empty()) return {position_m};

  std::vector<glm::vec3> ways{normals.front(), -normals.front()};
  if (normals.size() > 1) {
    // An edge, a corner, a sheet drawn twice: whatever meets here, one of these leads out of it.
    for (const glm::vec3& direction : ProbingDirections()) {
      ways.push_back(direction);
      ways.push_back(-direction);
    }
  }
  std::vector<glm::vec3> stands;
  for (const glm::vec3& way : ways) {
    const glm::vec3 stand = position_m + 2.0f * hair_m * way;
    if (TouchingNormals(caster, stand, 0.5f * hair_m).empty()) stands.push_back(stand);
  }
  return stands;
}

std::vector<std::uint8_t> InFreeAir(const RayCaster& caster,
                                    const ProbeGrid& grid,
                                    std::span<const std::optional<glm::vec3>> stands_m,
                                    std::span<const RayCounts> counts,
                                    int rays_per_probe) {
  const std::size_t probes = counts.size();
  std::vector<std::uint8_t> free(probes, 0);
  std::vector<std::size_t> reached;  // In free air, neighbours not yet asked.
  for (std::size_t i = 0; i < probes; ++i) {
    if (!stands_m[i]) continue;
    const bool backs =
        static_cast<float>(counts[i].back) > kMostBackShare * static_cast<float>(counts[i].Hits());
    const bool open =
        static_cast<float>(counts[i].sky) > kOpenSkyShare * static_cast<float>(rays_per_probe);
    free[i] = !backs || open ? 1 : 0;
    if (free[i] != 0) reached.push_back(i);
  }
  // What is reached at last is the same in whatever order it is reached.
  while (!reached.empty()) {
    const std::size_t from = reached.back();
    reached.pop_back();
    const glm::ivec3 cell(static_cast<int>(from) % grid.counts.x,
                          static_cast<int>(from) / grid.counts.x % grid.counts.y,
                          static_cast<int>(from) / (grid.counts.x * grid.counts.y));
    const glm::ivec3 lower = glm::max(cell - 1, glm::ivec3(0));
    const glm::ivec3 upper = glm::min(cell + 1, grid.counts - 1);
    for (int z = lower.z; z <= upper.z; ++z) {
      for (int y = lower.y; y <= upper.y; ++y) {
        for (int x = lower.x; x <= upper.x; ++x) {
          const auto to = static_cast<std::size_t>((z * grid.counts.y + y) * grid.counts.x + x);
          if (free[to] != 0 || !stands_m[to]) continue;
          const glm::vec3 way = *stands_m[to] - *stands_m[from];
          const float distance_m = glm::length(way);
          if (!(distance_m > 0.0f)) continue;
          if (caster.Occluded(*stands_m[from], way / distance_m, distance_m)) continue;
          free[to] = 1;
          reached.push_back(to);
        }
      }
    }
  }
  return free;
}

}  // namespace pleinair::internal

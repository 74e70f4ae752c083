#include "relight/transport/internal/ground_extension.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <glm/geometric.hpp>

#include "relight/transport/convex_hull.h"

namespace pleinair {
namespace {

// Near-horizontal: within 10 deg, steeper than any paved yard and flatter than any roof.
constexpr double kCosNearHorizontal = 0.985;
// Triangles whose middles are less than a kerb's height apart belong to one level.
constexpr double kLevelStepM = 0.3;

struct FlatTriangle {
  std::uint32_t index = 0;
  double height_m = 0.0;
  double area_m2 = 0.0;
};

std::vector<FlatTriangle> FlatTriangles(const Mesh& mesh) {
  std::vector<FlatTriangle> flat;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& v = mesh.triangles[i];
    const glm::dvec3 a(mesh.positions_m[v[0]]);
    const glm::dvec3 b(mesh.positions_m[v[1]]);
    const glm::dvec3 c(mesh.positions_m[v[2]]);
    const glm::dvec3 cross = glm::cross(b - a, c - a);
    const double twice_area = glm::length(cross);
    // Winding may be either way: a plane's sheet has no outside.
    if (!(std::abs(cross.z) > kCosNearHorizontal * twice_area)) continue;
    flat.push_back({static_cast<std::uint32_t>(i), (a.z + b.z + c.z) / 3.0, 0.5 * twice_area});
  }
  std::stable_sort(flat.begin(), flat.end(), [](const FlatTriangle& p, const FlatTriangle& q) {
    return p.height_m < q.height_m;
  });
  return flat;
}

}  // namespace

std::optional<Ground> FindGround(const Mesh& mesh) {
  const std::vector<FlatTriangle> flat = FlatTriangles(mesh);
  struct Level {
    std::size_t begin;
    std::size_t end;
    double area_m2;
  };
  std::vector<Level> levels;
  double largest_m2 = 0.0;
  for (std::size_t i = 0; i < flat.size(); ++i) {
    if (i == 0 || flat[i].height_m - flat[i - 1].height_m > kLevelStepM) {
      levels.push_back({i, i, 0.0});
    }
    levels.back().end = i + 1;
    levels.back().area_m2 += flat[i].area_m2;
    largest_m2 = std::max(largest_m2, levels.back().area_m2);
  }
  const auto level = std::find_if(levels.begin(), levels.end(), [largest_m2](const Level& l) {
    return l.area_m2 >= 0.25 * largest_m2;
  });
  if (level == levels.end() || !(largest_m2 > 0.0)) return std::nullopt;

  double height_area = 0.0;
  std::map<std::uint32_t, double> area_of_material;
  std::vector<glm::dvec2> corners;
  for (std::size_t i = level->begin; i < level->end; ++i) {
    height_area += flat[i].height_m * flat[i].area_m2;
    area_of_material[mesh.triangle_material[flat[i].index]] += flat[i].area_m2;
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec3& p = mesh.positions_m[mesh.triangles[flat[i].index][corner]];
      corners.emplace_back(p.x, p.y);
    }
  }
  Ground ground;
  ground.height_m = static_cast<float>(height_area / level->area_m2);
  ground.material =
      std::max_element(area_of_material.begin(),
                       area_of_material.end(),
                       [](const auto& p, const auto& q) { return p.second < q.second; })
          ->first;
  ground.outline_m = ConvexHull(corners);
  return ground;
}

bool EndsNear(const Ground& ground, const glm::dvec2& focus_m, double horizon_m) {
  const std::vector<glm::dvec2>& outline = ground.outline_m;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const glm::dvec2& from = outline[i];
    const glm::dvec2& to = outline[(i + 1) % outline.size()];
    if (TurnOf(from, to, focus_m) < horizon_m * glm::distance(from, to)) return true;
  }
  return false;
}

float LayGround(double radius_m, const glm::vec3& albedo, Mesh& mesh) {
  // Distance below the mesh as a share of its height, or of a room's: far more than rounding, far
  // less than is visible.
  constexpr float kHair = 1e-3f;
  constexpr float kLeastHeightM = 1.0f;
  const BoundingBox box = BoundingBoxOf(mesh);
  const float z_m = box.lower_m.z - kHair * std::max(kLeastHeightM, box.upper_m.z - box.lower_m.z);
  const glm::vec2 middle = 0.5f * (glm::vec2(box.lower_m) + glm::vec2(box.upper_m));
  const auto reach = static_cast<float>(radius_m);
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  for (const glm::vec2& corner : {glm::vec2(-reach, -reach),
                                  glm::vec2(reach, -reach),
                                  glm::vec2(reach, reach),
                                  glm::vec2(-reach, reach)}) {
    mesh.positions_m.emplace_back(middle + corner, z_m);
    if (!mesh.normals.empty()) mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);
  }
  const auto group = static_cast<std::uint32_t>(mesh.group_names.size());
  mesh.group_names.emplace_back(kGroundExtensionGroup);
  const auto material = static_cast<std::uint32_t>(mesh.materials.size());
  mesh.materials.push_back({.name = kGroundExtensionGroup, .diffuse_albedo = albedo});
  for (const glm::uvec3& triangle : {glm::uvec3(0, 1, 2), glm::uvec3(0, 2, 3)}) {
    mesh.triangles.push_back(triangle + first);
    mesh.triangle_material.push_back(material);
    mesh.triangle_group.push_back(group);
  }
  return z_m;
}

std::size_t AddGroundRing(const Ground& ground, double radius_m, Mesh& mesh) {
  const std::vector<glm::dvec2>& outline = ground.outline_m;
  if (outline.size() < 3) return 0;
  glm::dvec2 middle(0.0);
  for (const glm::dvec2& point : outline) middle += point;
  middle /= static_cast<double>(outline.size());

  // Corners of the outer border are those of the outline pushed out, and more where two of them
  // would leave the border's edge well inside the circle.
  constexpr double kLongestArcRad = 0.8;
  std::vector<glm::dvec2> inner;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const glm::dvec2& from = outline[i];
    const glm::dvec2& to = outline[(i + 1) % outline.size()];
    const glm::dvec2 u = from - middle;
    const glm::dvec2 v = to - middle;
    const double arc_rad = std::atan2(u.x * v.y - u.y * v.x, glm::dot(u, v));
    const int pieces = std::max(1, static_cast<int>(std::ceil(arc_rad / kLongestArcRad)));
    for (int piece = 0; piece < pieces; ++piece) {
      inner.push_back(from + (static_cast<double>(piece) / pieces) * (to - from));
    }
  }

  const auto group = static_cast<std::uint32_t>(mesh.group_names.size());
  mesh.group_names.emplace_back(kGroundExtensionGroup);
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  const auto count = static_cast<std::uint32_t>(inner.size());
  for (const glm::dvec2& point : inner) {
    const glm::dvec2 out = point - middle;
    const glm::dvec2 outer = middle + out * std::max(1.0, radius_m / glm::length(out));
    mesh.positions_m.emplace_back(point.x, point.y, ground.height_m);
    mesh.positions_m.emplace_back(outer.x, outer.y, ground.height_m);
    if (!mesh.normals.empty()) mesh.normals.insert(mesh.normals.end(), 2, {0.0f, 0.0f, 1.0f});
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t inner_here = first + 2 * i;
    const std::uint32_t inner_next = first + 2 * ((i + 1) % count);
    const glm::uvec3 quad[2] = {{inner_here, inner_here + 1, inner_next + 1},
                                {inner_here, inner_next + 1, inner_next}};
    for (const glm::uvec3& triangle : quad) {
      mesh.triangles.push_back(triangle);
      mesh.triangle_material.push_back(ground.material);
      mesh.triangle_group.push_back(group);
    }
  }
  return 2 * static_cast<std::size_t>(count);
}

}  // namespace pleinair

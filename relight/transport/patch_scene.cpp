#include "relight/transport/patch_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "relight/transport/internal/ground_extension.h"
#include "relight/transport/internal/patch_joining.h"
#include "relight/transport/internal/smooth_normals.h"
#include "relight/transport/patch_refinement.h"
#include "scene/low_discrepancy.h"

namespace pleinair {
namespace {

constexpr std::size_t kMaxPatches = std::size_t{1} << 21;
// A border nearer than this is not treated as the horizon: seen from eye height, ground at 1 km is
// within 0.1 deg of it.
constexpr double kNearHorizonM = 1000.0;
constexpr double kGroundRadiusM = 2000.0;
// For a plane that is laid under the mesh: few patches, because its albedo is only assumed.
constexpr double kLaidGroundGrowthPerM = 0.4;

constexpr float kNoLaidGround = std::numeric_limits<float>::quiet_NaN();

void CheckMesh(const Mesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  if (mesh.triangle_material.size() != count || mesh.triangle_group.size() != count) {
    throw std::invalid_argument("mesh: " + std::to_string(mesh.triangle_material.size()) +
                                " materials and " + std::to_string(mesh.triangle_group.size()) +
                                " groups for " + std::to_string(count) +
                                " triangles: expected one each a triangle");
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.triangles[i][corner] >= mesh.positions_m.size()) {
        throw std::invalid_argument("mesh: triangle " + std::to_string(i) +
                                    " names a vertex that is not there");
      }
    }
    if (mesh.triangle_material[i] >= mesh.materials.size() ||
        mesh.triangle_group[i] >= mesh.group_names.size()) {
      throw std::invalid_argument("mesh: triangle " + std::to_string(i) +
                                  " names a material or group that is not there");
    }
  }
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    const glm::vec3& p = mesh.positions_m[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw std::invalid_argument("mesh: vertex " + std::to_string(i) + " is not finite");
    }
  }
}

// `laid_ground_z_m`: height of the laid ground, below all else; NaN where there is none.
TargetLength TargetOf(const PatchOptions& options, float laid_ground_z_m) {
  return [options, laid_ground_z_m](const glm::vec3& midpoint_m) {
    const glm::dvec3 middle(midpoint_m);
    double distance_m = glm::distance(middle, options.focus_m);
    if (!options.focus_points_m.empty()) {
      double nearest2 = std::numeric_limits<double>::infinity();
      for (const glm::dvec3& point : options.focus_points_m) {
        const glm::dvec3 apart = middle - point;
        nearest2 = std::min(nearest2, glm::dot(apart, apart));
      }
      distance_m = std::sqrt(nearest2);
    }
    const double growth_per_m = midpoint_m.z == laid_ground_z_m
                                    ? std::max(options.growth_per_m, kLaidGroundGrowthPerM)
                                    : options.growth_per_m;
    return options.patch_size_m + growth_per_m * distance_m;
  };
}

}  // namespace

bool FitsPatchBudget(const Mesh& mesh, const PatchOptions& options, std::size_t budget) {
  options.Validate();
  CheckMesh(mesh);
  return TryRefineMesh(mesh, TargetOf(options, kNoLaidGround), budget).has_value();
}

void PatchOptions::Validate() const {
  const auto refuse = [](const char* field, double value, const char* expected) {
    throw std::invalid_argument(std::string(field) + " is " + std::to_string(value) +
                                ": expected " + expected);
  };
  if (!(ground_albedo >= 0.0) || !(ground_albedo < 1.0)) {
    refuse("ground_albedo", ground_albedo, "an albedo in [0, 1), 0 for none");
  }
  if (!(patch_size_m > 0.0) || !std::isfinite(patch_size_m)) {
    refuse("patch_size_m", patch_size_m, "a length > 0");
  }
  if (!(growth_per_m >= 0.0) || !std::isfinite(growth_per_m)) {
    refuse("growth_per_m", growth_per_m, "a ratio >= 0");
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(focus_m[axis])) refuse("focus_m", focus_m[axis], "finite coordinates");
    for (const glm::dvec3& point : focus_points_m) {
      if (!std::isfinite(point[axis])) refuse("focus_points_m", point[axis], "finite coordinates");
    }
  }
}

std::int32_t PatchScene::SideOfHit(const RayHit& hit, const glm::vec3& direction) {
  const auto front = static_cast<std::int32_t>(2 * hit.triangle);
  return glm::dot(hit.geometric_normal, direction) <= 0.0f ? front : front + 1;
}

glm::vec3 PatchScene::SideNormal(std::size_t side) const {
  const glm::vec3 normal = TriangleNormal(mesh, static_cast<std::uint32_t>(side / 2));
  return side % 2 == 0 ? normal : -normal;
}

glm::vec3 PatchScene::SurfaceNormal(std::size_t side) const {
  if (several.Empty()) return SideNormal(side);
  const glm::vec3& normal = several.smooth_normal[side / 2];
  return side % 2 == 0 ? normal : -normal;
}

glm::vec3 PatchScene::FaceNormal(std::size_t face) const {
  if (several.Empty()) return SideNormal(face);
  const glm::vec3& normal = several.normal[face / 2];
  return face % 2 == 0 ? normal : -normal;
}

glm::vec3 PatchScene::PatchMiddleM(std::size_t patch) const {
  const auto middle_m = [this](std::size_t triangle) {
    const glm::uvec3& v = mesh.triangles[triangle];
    return (mesh.positions_m[v.x] + mesh.positions_m[v.y] + mesh.positions_m[v.z]) / 3.0f;
  };
  if (several.Empty()) return middle_m(patch);
  glm::vec3 sum_m(0.0f);
  float before = 0.0f;
  for (std::size_t t = several.begin[patch]; t < several.begin[patch + 1]; ++t) {
    sum_m += (several.area_share_until[t] - before) * middle_m(t);
    before = several.area_share_until[t];
  }
  return sum_m;
}

float PatchScene::LongestEdgeM(std::size_t patch) const {
  if (IsJoined(patch)) return std::sqrt(2.0f * several.area_m2[patch]);
  const glm::uvec3& v = mesh.triangles[FirstTriangleOf(patch)];
  return std::max({glm::distance(mesh.positions_m[v.x], mesh.positions_m[v.y]),
                   glm::distance(mesh.positions_m[v.y], mesh.positions_m[v.z]),
                   glm::distance(mesh.positions_m[v.z], mesh.positions_m[v.x])});
}

PatchScene::Point PatchScene::PointOn(std::size_t patch, glm::dvec2 point) const {
  std::size_t triangle = FirstTriangleOf(patch);
  if (IsJoined(patch)) {
    // The square is divided along x among the triangles, by area.
    const auto first = several.area_share_until.begin() + static_cast<std::ptrdiff_t>(triangle);
    const auto last =
        several.area_share_until.begin() + static_cast<std::ptrdiff_t>(several.begin[patch + 1]);
    const auto chosen = std::upper_bound(first, last - 1, point.x);
    const double before = chosen == first ? 0.0 : double{*(chosen - 1)};
    triangle += static_cast<std::size_t>(chosen - first);
    point.x = std::clamp((point.x - before) / (double{*chosen} - before), 0.0, 1.0);
  }
  const glm::uvec3& v = mesh.triangles[triangle];
  return {TrianglePoint(mesh.positions_m[v.x], mesh.positions_m[v.y], mesh.positions_m[v.z], point),
          triangle};
}

double PatchScene::PatchAreaM2(std::size_t patch) const {
  if (!several.Empty()) return several.area_m2[patch];
  const glm::uvec3& v = mesh.triangles[patch];
  const glm::dvec3 a(mesh.positions_m[v[0]]);
  return 0.5 * glm::length(glm::cross(glm::dvec3(mesh.positions_m[v[1]]) - a,
                                      glm::dvec3(mesh.positions_m[v[2]]) - a));
}

PatchScene BuildPatchScene(const Mesh& mesh, const PatchOptions& options) {
  options.Validate();
  CheckMesh(mesh);
  Mesh whole = mesh;
  PatchScene scene;
  float laid_ground_z_m = kNoLaidGround;
  if (options.ground_albedo > 0.0 && !mesh.Empty()) {
    laid_ground_z_m =
        LayGround(kGroundRadiusM, glm::vec3(static_cast<float>(options.ground_albedo)), whole);
    scene.ground_laid = true;
  } else if (options.extend_ground) {
    const std::optional<Ground> ground = FindGround(mesh);
    if (ground && EndsNear(*ground, glm::dvec2(options.focus_m), kNearHorizonM)) {
      scene.ground_extended = AddGroundRing(*ground, kGroundRadiusM, whole) > 0;
    }
  }
  const TargetLength target = TargetOf(options, laid_ground_z_m);
  RefinedMesh refined = RefineMesh(whole, target, mesh.triangles.size() + kMaxPatches);
  if (options.join_small) {
    scene.several = internal::JoinSmallTriangles(
        target, static_cast<std::uint32_t>(mesh.triangles.size()), refined);
  }
  scene.mesh = std::move(refined.mesh);
  if (!scene.several.Empty()) {
    std::vector<std::uint8_t> is_small(scene.mesh.triangles.size());
    for (std::size_t t = 0; t < is_small.size(); ++t) {
      is_small[t] = scene.IsJoined(scene.PatchOf(t)) ? 1 : 0;
    }
    scene.several.smooth_normal = internal::SmoothNormals(scene.mesh, is_small);
  }
  scene.source_triangle = std::move(refined.source_triangle);
  for (std::uint32_t& source : scene.source_triangle) {
    if (source >= mesh.triangles.size()) source = PatchScene::kExtension;
  }
  if (scene.PatchCount() > kMaxPatches) {
    throw std::invalid_argument("patch size: the mesh would be cut into more than " +
                                std::to_string(kMaxPatches) +
                                " patches: expected a larger patch_size_m or growth_per_m");
  }
  scene.face_albedo_rgb.reserve(scene.FaceCount());
  for (std::size_t patch = 0; patch < scene.PatchCount(); ++patch) {
    scene.face_albedo_rgb.insert(scene.face_albedo_rgb.end(),
                                 2,
                                 scene.mesh.materials[scene.MaterialOf(patch)].diffuse_albedo);
  }
  scene.caster = RayCaster(scene.mesh);
  return scene;
}

}  // namespace pleinair

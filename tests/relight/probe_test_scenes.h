// Small scenes for the probes' tests: quads, patch scenes and surveys made by hand.
#pragma once

#include <numeric>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "relight/survey/survey.h"
#include "relight/transport/patch_scene.h"
#include "scene/lat_long.h"
#include "scene/mesh.h"

namespace pleinair {

// Corners counter-clockwise seen from the side that the normal points to.
inline void AddQuad(
    Mesh& mesh, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  const glm::vec3 normal = glm::normalize(glm::cross(b - a, c - a));
  mesh.positions_m.insert(mesh.positions_m.end(), {a, b, c, d});
  mesh.normals.insert(mesh.normals.end(), 4, normal);
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.triangles.emplace_back(first, first + 2, first + 3);
  mesh.triangle_material.insert(mesh.triangle_material.end(), 2, 0);
  mesh.triangle_group.insert(mesh.triangle_group.end(), 2, 0);
}

// Horizontal, normal up.
inline void AddGround(Mesh& mesh, float half_side_m, float height_m = 0.0f) {
  const float s = half_side_m;
  AddQuad(mesh, {-s, -s, height_m}, {s, -s, height_m}, {s, s, height_m}, {-s, s, height_m});
}

// Closed, normals outwards; `inside_out` turns them inwards.
inline void AddBox(Mesh& mesh,
                   const glm::vec3& lower,
                   const glm::vec3& upper,
                   bool inside_out = false,
                   bool with_top = true) {
  const auto quad = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
    inside_out ? AddQuad(mesh, d, c, b, a) : AddQuad(mesh, a, b, c, d);
  };
  const auto [x0, y0, z0] = std::array{lower.x, lower.y, lower.z};
  const auto [x1, y1, z1] = std::array{upper.x, upper.y, upper.z};
  quad({x0, y0, z0}, {x0, y1, z0}, {x1, y1, z0}, {x1, y0, z0});  // Down.
  quad({x0, y0, z0}, {x1, y0, z0}, {x1, y0, z1}, {x0, y0, z1});  // South.
  quad({x1, y0, z0}, {x1, y1, z0}, {x1, y1, z1}, {x1, y0, z1});  // East.
  quad({x1, y1, z0}, {x0, y1, z0}, {x0, y1, z1}, {x1, y1, z1});  // North.
  quad({x0, y1, z0}, {x0, y0, z0}, {x0, y0, z1}, {x0, y1, z1});  // West.
  if (with_top) quad({x0, y0, z1}, {x1, y0, z1}, {x1, y1, z1}, {x0, y1, z1});
}

// Each triangle is a patch, uncut; all faces have one albedo.
inline PatchScene SceneOf(Mesh mesh, const glm::vec3& albedo = glm::vec3(0.5f)) {
  PatchScene scene;
  scene.mesh = std::move(mesh);
  scene.mesh.materials.resize(1);
  scene.mesh.group_names = {"scene"};
  scene.face_albedo_rgb.assign(scene.FaceCount(), albedo);
  scene.source_triangle.resize(scene.mesh.triangles.size());
  std::iota(scene.source_triangle.begin(), scene.source_triangle.end(), 0u);
  scene.caster = RayCaster(scene.mesh);
  return scene;
}

// A ground with a house on it, some metres from the origin, and a low wall behind.
inline PatchScene Yard() {
  Mesh mesh;
  AddGround(mesh, 60.0f);
  AddBox(mesh, {3.0f, -4.0f, 0.0f}, {9.0f, 5.0f, 6.0f});
  AddBox(mesh, {-8.0f, -6.0f, 0.0f}, {-7.5f, 6.0f, 2.0f});
  return SceneOf(std::move(mesh), {0.5f, 0.4f, 0.3f});
}

// What a map taken at `position_m` shows of `scene`. The response to the sky is half the share of
// the upper hemisphere before the surface, to the sun its cosine where it isn't shaded; the bounces
// are a colour that neither has. Enough for what reads a survey; the transport's own figures are
// others.
inline Survey SurveyOf(const PatchScene& scene,
                       const glm::dvec3& position_m,
                       LatLongSize size,
                       const glm::dvec3& sun_direction_enu,
                       std::size_t sky_shapes = 1) {
  Survey survey;
  survey.position_m = position_m;
  SurfaceView& view = survey.view;
  view.sun_direction_enu = sun_direction_enu;
  view.region_names = {"scene"};
  view.region = {size.width, size.height, SurfaceView::kNoRegion};
  view.position_world_m = {size.width, size.height};
  view.normal_world = {size.width, size.height};
  view.albedo_rgb = {size.width, size.height};
  view.albedo_measured = {size.width, size.height};
  view.sun_visibility = {size.width, size.height};
  view.sun_bounce = {size.width, size.height};
  view.sky_response.assign(sky_shapes, {size.width, size.height});
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const glm::vec3 direction(DirectionFromLatLong({x + 0.5, y + 0.5}, size));
      const auto hit = scene.caster.Intersect(glm::vec3(position_m), direction);
      if (!hit) continue;
      const std::int32_t face = scene.FaceOfHit(*hit, direction);
      const glm::vec3 normal = face % 2 == 0 ? hit->geometric_normal : -hit->geometric_normal;
      view.region.At(x, y) = 0;
      view.position_world_m.At(x, y) = hit->position_m;
      view.normal_world.At(x, y) = normal;
      view.albedo_rgb.At(x, y) = scene.face_albedo_rgb[static_cast<std::size_t>(face)];
      view.albedo_measured.At(x, y) = 1;
      view.sun_visibility.At(x, y) =
          scene.caster.Occluded(OffsetFromSurface(hit->position_m, normal),
                                glm::vec3(sun_direction_enu))
              ? 0.0f
              : 1.0f;
      view.sun_bounce.At(x, y) = {0.02f, 0.05f, 0.01f};
      for (std::size_t k = 0; k < sky_shapes; ++k) {
        view.sky_response[k].At(x, y) =
            glm::vec3(0.5f + 0.5f * normal.z) / static_cast<float>(k + 1);
      }
    }
  }
  return survey;
}

}  // namespace pleinair

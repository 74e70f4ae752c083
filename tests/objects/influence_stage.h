// A view of real surfaces with an object before it, and what the object changes there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"
#include "objects/object_influence.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair {

// From `eye_m` to the horizon in the direction of x, a little down.
inline Camera LookingEast(const glm::dvec3& eye_m, int width_px = 160, int height_px = 120) {
  Camera camera;
  camera.intrinsics = {.width_px = width_px,
                       .height_px = height_px,
                       .fx_px = 0.8 * width_px,
                       .fy_px = 0.8 * width_px,
                       .cx_px = 0.5 * (width_px - 1),
                       .cy_px = 0.5 * (height_px - 1)};
  const glm::dvec3 forward = glm::normalize(glm::dvec3(1.0, 0.0, -0.25));
  const glm::dvec3 right(0.0, -1.0, 0.0);
  const glm::dmat3 camera_from_world =
      glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.camera_from_world = glm::dmat4(camera_from_world);
  camera.camera_from_world[3] = glm::dvec4(-(camera_from_world * eye_m), 1.0);
  return camera;
}

// What the camera sees of `scene`; the surfaces get no light, so that no change is too small.
inline SurfaceView ViewOf(const PatchScene& scene, const Camera& camera) {
  const int width = camera.intrinsics.width_px;
  const int height = camera.intrinsics.height_px;
  SurfaceView view;
  view.camera = camera;
  view.region_names = {"scene"};
  view.region = Image<std::int32_t>(width, height, SurfaceView::kNoRegion);
  view.position_world_m = RgbImage(width, height);
  view.normal_world = RgbImage(width, height);
  view.sky_response = {RgbImage(width, height), RgbImage(width, height)};
  view.sun_bounce = RgbImage(width, height);
  view.sun_visibility = GrayImage(width, height);
  const glm::vec3 eye_m(camera.CentreWorldM());
  const glm::dmat3 world_from_camera = glm::transpose(glm::dmat3(camera.camera_from_world));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3 direction(
          glm::normalize(world_from_camera * *DirectionFromPixel(camera.intrinsics, {x, y})));
      const auto hit = scene.caster.Intersect(eye_m, direction);
      if (!hit) continue;
      view.region.At(x, y) = 0;
      view.position_world_m.At(x, y) = hit->position_m;
      const bool is_front = PatchScene::SideOfHit(*hit, direction) % 2 == 0;
      view.normal_world.At(x, y) = is_front ? hit->geometric_normal : -hit->geometric_normal;
    }
  }
  return view;
}

// Whether the object hides a pixel's surface from the camera.
inline bool IsCovered(const PatchScene& object, const SurfaceView& view, std::size_t pixel) {
  const glm::vec3 eye_m(view.camera.CentreWorldM());
  const glm::vec3 apart = view.position_world_m.pixels[pixel] - eye_m;
  return object.caster.Occluded(eye_m, glm::normalize(apart), 0.999f * glm::length(apart));
}

struct InfluenceStage {
  PatchScene real;
  PatchScene object;
  SurfaceView view;
  ObjectInfluence influence;

  InfluenceStage(Mesh real_mesh, Mesh object_mesh, const Camera& camera)
      : real(SceneOf(std::move(real_mesh))),
        object(SceneOf(std::move(object_mesh))),
        view(ViewOf(real, camera)),
        influence(real, object, view) {}

  std::vector<glm::vec3> RealGlow(const glm::vec3& radiosity) const {
    return std::vector<glm::vec3>(real.FaceCount(), radiosity);
  }
  std::vector<glm::vec3> ObjectGlow(const glm::vec3& radiosity) const {
    return std::vector<glm::vec3>(object.FaceCount(), radiosity);
  }
  // Light 0 is the sun, which nothing reflects.
  void FoldNoSun() {
    influence.Fold(0, {nullptr, RealGlow(glm::vec3(0.0f)), ObjectGlow(glm::vec3(0.0f))}, view);
  }
  // Light 1 is a uniform sky, whose light real and virtual faces have the given radiosity of.
  void FoldUniformSky(const glm::vec3& real_glow, const glm::vec3& object_glow) {
    influence.Fold(
        1, {MakeUniformSkyShape().get(), RealGlow(real_glow), ObjectGlow(object_glow)}, view);
  }
  // In picture size.
  RgbImage Change(const Lighting& lighting, const InfluenceParts& parts = {}) const {
    IrradianceChange change;
    influence.Evaluate(lighting, parts, change);
    RgbImage whole(view.Width(), view.Height(), glm::vec3(0.0f));
    for (int y = 0; y < change.irradiance_rgb.height; ++y) {
      for (int x = 0; x < change.irradiance_rgb.width; ++x) {
        whole.At(change.x_px + x, change.y_px + y) = change.irradiance_rgb.At(x, y);
      }
    }
    return whole;
  }
};

// So wide that no ray below the horizon passes its end, but for the last of float's steps.
inline Mesh Ground(float half_side_m = 1e4f) {
  Mesh mesh;
  AddGround(mesh, half_side_m);
  return mesh;
}

inline Lighting OneSky(const glm::dvec3& irradiance_rgb) {
  Lighting lighting;
  lighting.sky = {{"uniform", irradiance_rgb}};
  return lighting;
}

}  // namespace pleinair

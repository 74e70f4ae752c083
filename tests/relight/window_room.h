// A room with one window, for tests of indoor light.
#pragma once

#include <array>

#include "relight/transport/patch_scene.h"
#include "tests/relight/probe_test_scenes.h"

namespace pleinair {

// 4 x 4 x 3 m inside, from the origin; walls, floor and ceiling are slabs of 25 cm that meet and
// overlap at the corners, as walls are drawn. The window is in the south wall, 1.6 x 1.2 m. One
// material: "all".
inline Mesh RoomWithWindow(const glm::vec3& albedo) {
  constexpr float kThick = 0.25f;
  Mesh mesh;
  const auto slab = [&](const glm::vec3& lower, const glm::vec3& upper) {
    AddBox(mesh, lower, upper);
  };
  slab({-kThick, -kThick, -kThick}, {4.0f + kThick, 4.0f + kThick, 0.0f});
  slab({-kThick, -kThick, 3.0f}, {4.0f + kThick, 4.0f + kThick, 3.0f + kThick});
  slab({-kThick, 4.0f, 0.0f}, {4.0f + kThick, 4.0f + kThick, 3.0f});
  slab({-kThick, -kThick, 0.0f}, {0.0f, 4.0f + kThick, 3.0f});
  slab({4.0f, -kThick, 0.0f}, {4.0f + kThick, 4.0f + kThick, 3.0f});
  slab({0.0f, -kThick, 0.0f}, {1.2f, 0.0f, 3.0f});
  slab({2.8f, -kThick, 0.0f}, {4.0f, 0.0f, 3.0f});
  slab({1.2f, -kThick, 0.0f}, {2.8f, 0.0f, 0.9f});
  slab({1.2f, -kThick, 2.1f}, {2.8f, 0.0f, 3.0f});
  mesh.materials.assign(1, {.name = "all", .diffuse_albedo = albedo});
  mesh.group_names = {"room"};
  return mesh;
}

inline PatchScene CutRoom(const Mesh& mesh, double patch_size_m) {
  PatchOptions options;
  options.patch_size_m = patch_size_m;
  options.growth_per_m = 0.0;
  options.extend_ground = false;
  return BuildPatchScene(mesh, options);
}

}  // namespace pleinair

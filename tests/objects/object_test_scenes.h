// What tests of objects in a picture share: plates, a mesh as a scene, and a camera over it.
#pragma once

#include <cstdint>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "scene/camera.h"
#include "scene/mesh.h"

namespace pleinair {

// Each triangle is a patch, uncut; materials and groups stay, all faces have one albedo.
inline PatchScene PatchesOf(const Mesh& mesh, float albedo = 0.5f) {
  PatchScene scene;
  scene.mesh = mesh;
  scene.caster = RayCaster(scene.mesh);
  scene.face_albedo_rgb.assign(scene.FaceCount(), glm::vec3(albedo));
  return scene;
}

// Adds a level rectangle that faces up.
inline void AddPlate(const glm::vec2& lower_m, const glm::vec2& upper_m, float z_m, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions_m.size());
  mesh.positions_m.insert(mesh.positions_m.end(),
                          {glm::vec3(lower_m, z_m),
                           glm::vec3(upper_m.x, lower_m.y, z_m),
                           glm::vec3(upper_m, z_m),
                           glm::vec3(lower_m.x, upper_m.y, z_m)});
  mesh.normals.resize(mesh.positions_m.size(), glm::vec3(0.0f, 0.0f, 1.0f));
  mesh.triangles.push_back(glm::uvec3(0, 1, 2) + first);
  mesh.triangles.push_back(glm::uvec3(0, 2, 3) + first);
  mesh.triangle_group.resize(mesh.triangles.size(), 0);
  mesh.group_names = {"plate"};
}

// Looks straight down from 10 m at a square of 2 m around the origin: 64 px, 3.1 cm each.
inline Camera FromAbove() {
  Camera camera;
  camera.intrinsics = {64, 64, 320.0, 320.0, 31.5, 31.5, {}};
  camera.camera_from_world[1][1] = -1.0;
  camera.camera_from_world[2][2] = -1.0;
  camera.camera_from_world[3][2] = 10.0;
  return camera;
}

}  // namespace pleinair

// What tests of objects in a picture share: a mesh as a scene, and a camera over it.
#pragma once

#include <glm/mat4x4.hpp>

#include "relight/transport/patch_scene.h"
#include "scene/camera.h"

namespace pleinair {

// Each triangle is a patch, uncut; materials and groups stay, all faces have one albedo.
inline PatchScene PatchesOf(const Mesh& mesh, float albedo = 0.5f) {
  PatchScene scene;
  scene.mesh = mesh;
  scene.caster = RayCaster(scene.mesh);
  scene.face_albedo_rgb.assign(scene.FaceCount(), glm::vec3(albedo));
  return scene;
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

// Which parts of virtual objects the samples of a picture show.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "relight/transport/patch_scene.h"
#include "scene/camera.h"
#include "scene/image.h"

namespace pleinair {

// Covers the part of the undistorted picture (see UndistortedCover) in which objects may be
// visible. Real surfaces are left out: it is cheaper to test where needed what they hide.
struct ObjectView {
  static constexpr int kSamplesPerSide = 2;  // Samples along a pixel's side.
  static constexpr std::uint32_t kNothing = 0xffffffffu;
  struct Sample {
    std::uint32_t triangle = kNothing;
    glm::vec2 barycentric{0.0f};
  };

  int x_px = 0;  // Place of the first pixel in the undistorted picture.
  int y_px = 0;
  int width_px = 0;
  int height_px = 0;
  glm::vec3 eye_m{0.0f};
  glm::dmat3 world_from_picture{1.0};  // From (u, v, 1), a place of that picture, to its ray.
  Image<Sample> samples;               // kSamplesPerSide times as wide and as high.

  bool Empty() const { return samples.Empty(); }
};

// What a sample that is not kNothing shows, on the objects' mesh in the world.
struct ObjectPlace {
  glm::vec3 position_m{0.0f};
  glm::vec3 normal{0.0f};  // Unit, of the triangle, turned to the eye.
};
ObjectPlace PlaceOf(const ObjectView::Sample& sample, const Mesh& mesh, const glm::vec3& eye_m);

// The same on the curved surface that the shading normals mean, where that bulges out to the eye's
// side; its normal is the shading one. Rays towards a light leave from there, so that a shadow's
// edge on a smooth object does not follow the triangles. (Hanika 2021, "Hacking the shadow
// terminator", Ray Tracing Gems II, chapter 4.)
ObjectPlace SmoothPlaceOf(const ObjectView::Sample& sample,
                          const Mesh& mesh,
                          const glm::vec3& eye_m);

// One ray a sample. `objects` in the world; only their mesh and caster are looked at.
// Threads  The result does not depend on their number.
ObjectView SeeObjects(const PatchScene& objects, const Camera& camera);

// What the eye sees at other places of that picture, which is not empty: so that a mean over a
// pixel can be one over its square. `samples` gets an entry each of `places_px`.
void SeeObjectsAt(const ObjectView& view,
                  const PatchScene& objects,
                  std::span<const glm::dvec2> places_px,
                  std::vector<ObjectView::Sample>& samples);

}  // namespace pleinair

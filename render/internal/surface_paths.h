// How shadows move over real surfaces during an exposure. No OpenGL here.
#pragma once

#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "objects/virtual_object.h"
#include "render/internal/exposed_rows.h"
#include "render/internal/pixel_paths.h"
#include "scene/exposure_motion.h"
#include "scene/pixel_rect.h"
#include "scene/surface_view.h"

namespace pleinair {

// What objects change on real surfaces moves over the plane that a pixel shows: with the camera,
// and with the part of the nearest object that the sun's ray passes closest to its middle.
class SurfacePaths {
 public:
  enum class Carried { kSunShadow, kOtherLight };

  // `motion` and `view` outlive this. `objects` are where they are at the frame's instant.
  SurfacePaths(const ExposureMotion& motion,
               const SurfaceView& view,
               const glm::dvec3& to_sun,
               std::span<const VirtualObject> objects);

  // Paths of all pixels that something inside `of_image` may pass through.
  PixelPaths Over(const PixelRect& of_image, Carried carried) const;
  // Whether two pixels show one surface, as far as shadows on it are concerned.
  bool IsOnSurfaceOf(const glm::ivec2& pixel, const glm::ivec2& other) const;

 private:
  const ExposureMotion& motion_;
  const SurfaceView& view_;
  glm::dvec3 to_sun_;
  glm::dvec3 eye_m_;
  std::vector<BoundingBox> boxes_;
  ExposedRows camera_motion_;               // In the world.
  std::vector<ExposedRows> object_undone_;  // In the world: back to the frame's instant.

  glm::vec4 PathOf(const glm::ivec2& pixel, Carried carried) const;
};

}  // namespace pleinair

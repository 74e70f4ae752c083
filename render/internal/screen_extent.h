// The part of a picture in which geometry can be visible, and its least depth. No OpenGL here.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "render/internal/shadow_caster.h"
#include "scene/camera.h"
#include "scene/mesh.h"
#include "scene/pixel_rect.h"

namespace pleinair {

PixelRect WholePicture(const CameraIntrinsics& intrinsics);

struct ScreenExtent {
  // Depth along the optical axis of the nearest point in view; infinite where nothing is.
  double nearest_m = std::numeric_limits<double>::infinity();
  PixelRect rect;  // One pixel of margin, inside the picture.
};

// Extent of the parts of triangles in an undistorted camera's view, clipped exactly to it.
ScreenExtent ExtentOf(std::span<const glm::vec3> positions,
                      std::span<const glm::uvec3> triangles,
                      const CameraIntrinsics& intrinsics,
                      const glm::dmat4& camera_from_positions);

// Where a shadow that `casters` throw can fall on surfaces inside `receivers`. A bound: the box's
// shadow instead of the caster's own.
PixelRect ShadowExtentOf(const BoundingBox& casters,
                         const BoundingBox& receivers,
                         const glm::dvec3& to_sun,
                         const CameraIntrinsics& intrinsics,
                         const glm::dmat4& camera_from_positions);

}  // namespace pleinair

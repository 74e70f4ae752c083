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

namespace pleinair {

// Pixels lower <= (x, y) < upper; empty where upper <= lower.
struct PixelRect {
  glm::ivec2 lower{0};
  glm::ivec2 upper{0};

  bool Empty() const { return upper.x <= lower.x || upper.y <= lower.y; }
  int Width() const { return upper.x - lower.x; }
  int Height() const { return upper.y - lower.y; }
  std::size_t Count() const {
    return Empty() ? 0 : static_cast<std::size_t>(Width()) * static_cast<std::size_t>(Height());
  }
  bool Holds(const glm::ivec2& pixel) const {
    return pixel.x >= lower.x && pixel.y >= lower.y && pixel.x < upper.x && pixel.y < upper.y;
  }
  // Index of a pixel inside, in row-major order.
  std::size_t Index(const glm::ivec2& pixel) const {
    return static_cast<std::size_t>(pixel.y - lower.y) * static_cast<std::size_t>(Width()) +
           static_cast<std::size_t>(pixel.x - lower.x);
  }
  bool operator==(const PixelRect&) const = default;
};

PixelRect UnionOf(const PixelRect& a, const PixelRect& b);
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

#include "render/internal/view_projection.h"

namespace pleinair {

glm::dmat4 ClipFromCamera(const CameraIntrinsics& intrinsics, double near_m) {
  // Infinity maps to z/w = 1 - kFarMargin, so that rounding cannot push the far ends of shadow
  // volumes out of the clip volume. The margin is two steps of a 24-bit depth buffer. Source:
  // Everitt and Kilgard 2002, "Practical and robust stenciled shadow volumes", section 4.
  constexpr double kFarMargin = 1.0 / (1 << 22);
  const double width = intrinsics.width_px;
  const double height = intrinsics.height_px;
  const glm::dvec2 centre = WindowFromPixel({intrinsics.cx_px, intrinsics.cy_px});
  glm::dmat4 clip(0.0);  // Columns.
  clip[0][0] = 2.0 * intrinsics.fx_px / width;
  clip[1][1] = 2.0 * intrinsics.fy_px / height;
  clip[2][0] = 2.0 * centre.x / width - 1.0;
  clip[2][1] = 2.0 * centre.y / height - 1.0;
  clip[2][2] = 1.0 - kFarMargin;
  clip[2][3] = 1.0;
  clip[3][2] = -(2.0 - kFarMargin) * near_m;
  return clip;
}

glm::dmat4 ClipOfRect(const CameraIntrinsics& intrinsics,
                      const glm::ivec2& lower,
                      const glm::ivec2& upper) {
  // Window = size (clip + w) / 2 in, rect = 2 (window - lower) / (upper - lower) - 1 out.
  const glm::dvec2 size(intrinsics.width_px, intrinsics.height_px);
  const glm::dvec2 extent(upper - lower);
  const glm::dvec2 scale = size / extent;
  const glm::dvec2 offset = (size - 2.0 * glm::dvec2(lower)) / extent - 1.0;
  glm::dmat4 rect(1.0);
  rect[0][0] = scale.x;
  rect[1][1] = scale.y;
  rect[3][0] = offset.x;
  rect[3][1] = offset.y;
  return rect;
}

}  // namespace pleinair

#include "render/internal/screen_extent.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace pleinair {
namespace {

// Points p with dot(xyz, p) + w >= 0 are kept.
using Plane = glm::dvec4;

double Distance(const Plane& plane, const glm::dvec3& point) {
  return glm::dot(glm::dvec3(plane), point) + plane.w;
}

// The four sides of the pyramid that an undistorted picture sees, in camera coordinates. Together
// they leave nothing behind the camera.
std::array<Plane, 4> ViewPyramid(const CameraIntrinsics& intrinsics) {
  const double left = intrinsics.cx_px + 0.5;
  const double right = intrinsics.width_px - 0.5 - intrinsics.cx_px;
  const double top = intrinsics.cy_px + 0.5;
  const double bottom = intrinsics.height_px - 0.5 - intrinsics.cy_px;
  return {Plane(intrinsics.fx_px, 0.0, left, 0.0),
          Plane(-intrinsics.fx_px, 0.0, right, 0.0),
          Plane(0.0, intrinsics.fy_px, top, 0.0),
          Plane(0.0, -intrinsics.fy_px, bottom, 0.0)};
}

// Sutherland and Hodgman. A convex polygon of four corners cut by ten planes has at most 14
// corners; the room above that is for corners that rounding puts out of line.
class Polygon {
 public:
  static constexpr std::size_t kMaxCorners = 32;

  void Add(const glm::dvec3& corner) {
    if (count_ < kMaxCorners) corners_[count_++] = corner;
  }
  void Cut(const Plane& plane) {
    Polygon kept;
    for (std::size_t i = 0; i < count_; ++i) {
      const glm::dvec3& from = corners_[i];
      const glm::dvec3& to = corners_[(i + 1) % count_];
      const double from_distance = Distance(plane, from);
      const double to_distance = Distance(plane, to);
      if (from_distance >= 0.0) kept.Add(from);
      if ((from_distance >= 0.0) != (to_distance >= 0.0)) {
        kept.Add(from + (to - from) * (from_distance / (from_distance - to_distance)));
      }
    }
    *this = kept;
  }
  std::span<const glm::dvec3> Corners() const { return {corners_.data(), count_}; }

 private:
  std::array<glm::dvec3, kMaxCorners> corners_{};
  std::size_t count_ = 0;
};

// Gathers points of camera space into a rectangle of pixels.
class RectBuilder {
 public:
  explicit RectBuilder(const CameraIntrinsics& intrinsics) : intrinsics_(intrinsics) {}

  void Add(const glm::dvec3& point) {
    // In front of the pyramid's tip every direction is possible.
    if (!(point.z > 0.0)) {
      lower_ = glm::dvec2(-std::numeric_limits<double>::infinity());
      upper_ = glm::dvec2(std::numeric_limits<double>::infinity());
      return;
    }
    const glm::dvec2 pixel(intrinsics_.fx_px * point.x / point.z + intrinsics_.cx_px,
                           intrinsics_.fy_px * point.y / point.z + intrinsics_.cy_px);
    lower_ = glm::min(lower_, pixel);
    upper_ = glm::max(upper_, pixel);
  }

  PixelRect Rect() const {
    if (!(lower_.x <= upper_.x)) return {};
    const glm::dvec2 size(intrinsics_.width_px, intrinsics_.height_px);
    return {glm::ivec2(glm::clamp(glm::floor(lower_) - 1.0, glm::dvec2(0.0), size)),
            glm::ivec2(glm::clamp(glm::ceil(upper_) + 2.0, glm::dvec2(0.0), size))};
  }

 private:
  const CameraIntrinsics& intrinsics_;
  glm::dvec2 lower_{std::numeric_limits<double>::infinity()};
  glm::dvec2 upper_{-std::numeric_limits<double>::infinity()};
};

// A box's faces, counter-clockwise from outside, over the corners of CornersOf.
constexpr std::array<std::array<std::uint32_t, 4>, 6> kBoxFaces{
    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};

}  // namespace

PixelRect WholePicture(const CameraIntrinsics& intrinsics) {
  return {{0, 0}, {intrinsics.width_px, intrinsics.height_px}};
}

ScreenExtent ExtentOf(std::span<const glm::vec3> positions,
                      std::span<const glm::uvec3> triangles,
                      const CameraIntrinsics& intrinsics,
                      const glm::dmat4& camera_from_positions) {
  const std::array<Plane, 4> pyramid = ViewPyramid(intrinsics);
  std::vector<glm::dvec3> in_camera(positions.size());
  std::vector<std::uint8_t> outside(positions.size(), 0);  // A bit a plane.
  for (std::size_t i = 0; i < positions.size(); ++i) {
    in_camera[i] = glm::dvec3(camera_from_positions * glm::dvec4(glm::dvec3(positions[i]), 1.0));
    for (std::size_t plane = 0; plane < pyramid.size(); ++plane) {
      if (!(Distance(pyramid[plane], in_camera[i]) >= 0.0)) {
        outside[i] = static_cast<std::uint8_t>(outside[i] | (1u << plane));
      }
    }
  }
  ScreenExtent extent;
  RectBuilder rect(intrinsics);
  const auto add = [&](const glm::dvec3& point) {
    extent.nearest_m = std::min(extent.nearest_m, std::max(point.z, 0.0));
    rect.Add(point);
  };
  for (const glm::uvec3& triangle : triangles) {
    if ((outside[triangle.x] & outside[triangle.y] & outside[triangle.z]) != 0) continue;
    const int crossed = outside[triangle.x] | outside[triangle.y] | outside[triangle.z];
    Polygon polygon;
    for (int corner = 0; corner < 3; ++corner) polygon.Add(in_camera[triangle[corner]]);
    for (std::size_t plane = 0; crossed != 0 && plane < pyramid.size(); ++plane) {
      if ((crossed & (1 << plane)) != 0) polygon.Cut(pyramid[plane]);
    }
    for (const glm::dvec3& corner : polygon.Corners()) add(corner);
  }
  extent.rect = rect.Rect();
  return extent;
}

PixelRect ShadowExtentOf(const BoundingBox& casters,
                         const BoundingBox& receivers,
                         const glm::dvec3& to_sun,
                         const CameraIntrinsics& intrinsics,
                         const glm::dmat4& camera_from_positions) {
  // The box's shadow, cut off where the last receiver lies behind it, is a convex body: its faces
  // are clipped to the receivers' box and to the view. The rest is bounded by the receivers' box
  // itself, whose corners in shadow are found separately.
  const std::array<glm::vec3, 8> receiver_corners = CornersOf(receivers);
  const std::array<glm::vec3, 8> caster_corners = CornersOf(casters);
  double highest = -std::numeric_limits<double>::infinity();
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 8; ++i) {
    highest = std::max(highest, glm::dot(to_sun, glm::dvec3(caster_corners[i])));
    lowest = std::min(lowest, glm::dot(to_sun, glm::dvec3(receiver_corners[i])));
  }
  if (lowest > highest) return {};
  const glm::dvec3 sweep = -(highest - lowest) * to_sun;

  // A rounding margin, so that receivers that are one flat sheet are not clipped away.
  const glm::dvec3 size(glm::max(glm::abs(receivers.lower_m), glm::abs(receivers.upper_m)));
  const double margin = 1e-5 * (1e-3 + std::max({size.x, size.y, size.z}));
  const glm::dvec3 lower = glm::dvec3(receivers.lower_m) - margin;
  const glm::dvec3 upper = glm::dvec3(receivers.upper_m) + margin;
  const std::array<Plane, 6> sides{Plane(1.0, 0.0, 0.0, -lower.x),
                                   Plane(-1.0, 0.0, 0.0, upper.x),
                                   Plane(0.0, 1.0, 0.0, -lower.y),
                                   Plane(0.0, -1.0, 0.0, upper.y),
                                   Plane(0.0, 0.0, 1.0, -lower.z),
                                   Plane(0.0, 0.0, -1.0, upper.z)};
  const std::array<Plane, 4> pyramid = ViewPyramid(intrinsics);
  RectBuilder rect(intrinsics);
  const auto add_face = [&](std::span<const glm::dvec3> face) {
    Polygon polygon;
    for (const glm::dvec3& corner : face) polygon.Add(corner);
    for (const Plane& side : sides) polygon.Cut(side);
    Polygon in_view;
    for (const glm::dvec3& corner : polygon.Corners()) {
      in_view.Add(glm::dvec3(camera_from_positions * glm::dvec4(corner, 1.0)));
    }
    for (const Plane& side : pyramid) in_view.Cut(side);
    for (const glm::dvec3& corner : in_view.Corners()) rect.Add(corner);
  };
  for (const auto& face : kBoxFaces) {
    std::array<glm::dvec3, 4> near_face;
    std::array<glm::dvec3, 4> far_face;
    for (std::size_t i = 0; i < 4; ++i) {
      near_face[i] = glm::dvec3(caster_corners[face[i]]);
      far_face[i] = near_face[i] + sweep;
    }
    add_face(near_face);
    add_face(far_face);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t next = (i + 1) % 4;
      add_face(std::array{near_face[i], near_face[next], far_face[next], far_face[i]});
    }
  }
  // Where a corner of the receivers' box, or the camera, lies in the shadow, the faces above bound
  // nothing.
  const glm::dmat3 camera_rotation(camera_from_positions);
  const glm::dvec3 camera_centre =
      -glm::transpose(camera_rotation) * glm::dvec3(camera_from_positions[3]);
  const auto in_box_shadow = [&](const glm::dvec3& point) {
    // A ray to the sun against a slightly larger box.
    double from = 0.0;
    double to = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const double low = static_cast<double>(casters.lower_m[axis]) - margin - point[axis];
      const double high = static_cast<double>(casters.upper_m[axis]) + margin - point[axis];
      if (to_sun[axis] == 0.0) {
        if (low > 0.0 || high < 0.0) return false;
        continue;
      }
      from = std::max(from, std::min(low / to_sun[axis], high / to_sun[axis]));
      to = std::min(to, std::max(low / to_sun[axis], high / to_sun[axis]));
    }
    return from <= to;
  };
  for (const glm::vec3& corner : receiver_corners) {
    if (in_box_shadow(glm::dvec3(corner))) return WholePicture(intrinsics);
  }
  if (in_box_shadow(camera_centre)) return WholePicture(intrinsics);
  return rect.Rect();
}

}  // namespace pleinair

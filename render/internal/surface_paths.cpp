#include "render/internal/surface_paths.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/lens.h"

namespace pleinair {
namespace {

// The middle of a ray's way through a box, or where it passes closest by.
glm::dvec3 CasterNear(const glm::dvec3& start,
                      const glm::dvec3& direction,
                      const glm::dvec3& lower,
                      const glm::dvec3& upper) {
  double enters = -std::numeric_limits<double>::infinity();
  double leaves = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) continue;
    const double a = (lower[axis] - start[axis]) / direction[axis];
    const double b = (upper[axis] - start[axis]) / direction[axis];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  return start + std::max(0.5 * (enters + leaves), 0.0) * direction;
}

}  // namespace

SurfacePaths::SurfacePaths(const ExposureMotion& motion,
                           const SurfaceView& view,
                           const glm::dvec3& to_sun,
                           std::span<const VirtualObject> objects)
    : motion_(motion),
      view_(view),
      to_sun_(to_sun),
      eye_m_(glm::inverse(view.camera.camera_from_world)[3]),
      camera_motion_(OverRows(
          motion, view.Height(), [&](double seconds) { return motion.camera.After(seconds); })) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    boxes_.push_back(objects[i].mesh.Empty() ? BoundingBox() : BoundingBoxOf(objects[i].mesh));
    object_undone_.push_back(OverRows(motion, view.Height(), [&](double seconds) {
      return glm::inverse(motion.objects[i].After(seconds));
    }));
  }
}

// Where the surface of a pixel was, for its shadow, when it is the one of the frame's instant.
glm::vec4 SurfacePaths::PathOf(const glm::ivec2& pixel, Carried carried) const {
  const std::size_t index = view_.region.Index(pixel.x, pixel.y);
  const glm::dvec3 normal(view_.normal_world.pixels[index]);
  if (normal == glm::dvec3(0.0)) return glm::vec4(0.0f);
  const glm::dvec3 place(view_.position_world_m.pixels[index]);
  const std::size_t row = camera_motion_.IndexOf(pixel.y);
  const auto offset = [&](const ExposedRows& camera, auto of_rows) -> glm::vec2 {
    glm::dvec3 now = place;
    if (motion_.camera.Moves()) {
      const glm::dmat4& moved = (camera.*of_rows)[row];
      const glm::dvec3 eye(moved * glm::dvec4(eye_m_, 1.0));
      const glm::dvec3 ray = glm::dmat3(moved) * (place - eye_m_);
      const double share = glm::dot(normal, place - eye) / glm::dot(normal, ray);
      // A plane that is seen from its edge has been left meanwhile.
      if (share > 0.5 && share < 2.0) now = eye + share * ray;
    }
    glm::dvec3 then = now;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const glm::dvec3 lower(boxes_[i].lower_m);
      const glm::dvec3 upper(boxes_[i].upper_m);
      const glm::dvec3 middle = 0.5 * (lower + upper);
      const double radius = std::max(0.5 * glm::distance(lower, upper), 1e-12);
      const glm::dvec3 caster =
          carried == Carried::kSunShadow ? CasterNear(now, to_sun_, lower, upper) : now;
      const double away = glm::distance(caster, middle) / radius;
      if (!(away < nearest)) continue;
      nearest = away;
      then = now;
      if (!motion_.objects[i].Moves()) continue;
      const glm::dvec3 back((object_undone_[i].*of_rows)[row] * glm::dvec4(caster, 1.0));
      const double above = glm::dot(normal, back - place);
      const double sine = glm::dot(normal, to_sun_);
      if (carried == Carried::kOtherLight) {
        then = back - above * normal;
      } else if (sine > 1e-3) {
        then = back - (above / sine) * to_sun_;
      }
    }
    const glm::dvec3 seen(view_.camera.camera_from_world * glm::dvec4(then, 1.0));
    if (!(seen.z > 0.0)) return glm::vec2(0.0f);
    const auto at = ProjectToPixel(view_.camera.intrinsics, seen);
    return at ? glm::vec2(*at - glm::dvec2(pixel)) : glm::vec2(0.0f);
  };
  return {offset(camera_motion_, &ExposedRows::start), offset(camera_motion_, &ExposedRows::end)};
}

bool SurfacePaths::IsOnSurfaceOf(const glm::ivec2& pixel, const glm::ivec2& other) const {
  if (other == pixel) return true;
  if (!view_.region.Contains(other.x, other.y)) return false;
  const std::size_t index = view_.region.Index(pixel.x, pixel.y);
  const std::size_t index_of_other = view_.region.Index(other.x, other.y);
  if (view_.region.pixels[index_of_other] == SurfaceView::kNoRegion) return false;
  constexpr double kOff = 0.05;  // Share of the distance: far more than relief and a mesh's noise.
  const glm::dvec3 place(view_.position_world_m.pixels[index_of_other]);
  const glm::dvec3 from(view_.position_world_m.pixels[index]);
  const glm::dvec3 normal(view_.normal_world.pixels[index]);
  return std::abs(glm::dot(normal, place - from)) < kOff * glm::distance(place, eye_m_);
}

PixelPaths SurfacePaths::Over(const PixelRect& of_image, Carried carried) const {
  glm::vec2 reach(0.0f);
  constexpr int kAsked = 8;  // A pixel among so many in a row or column.
  for (int y = of_image.lower.y; y < of_image.upper.y; y += kAsked) {
    for (int x = of_image.lower.x; x < of_image.upper.x; x += kAsked) {
      const glm::vec4 ends = glm::abs(PathOf({x, y}, carried));
      reach = glm::max(reach, glm::max(glm::vec2(ends.x, ends.y), glm::vec2(ends.z, ends.w)));
    }
  }
  constexpr float kMost = 1.2f;  // Factor over the sampled shifts.
  const glm::ivec2 margin =
      glm::min(glm::ivec2(glm::ceil(kMost * reach)) + 2, glm::ivec2(view_.Width(), view_.Height()));
  PixelPaths paths{
      ClippedTo({of_image.lower - margin, of_image.upper + margin}, view_.Width(), view_.Height()),
      {}};
  paths.ends.resize(paths.rect.Count());
  constexpr int kSpacing = 2;
  ForPixels(paths.rect, [&](const glm::ivec2& pixel) {
    if (pixel % kSpacing == glm::ivec2(0)) {
      paths.ends[paths.rect.Index(pixel)] = PathOf(pixel, carried);
    }
  });
  // Those of a surface are nearly the same for pixels so near to each other.
  ForPixels(paths.rect, [&](const glm::ivec2& pixel) {
    const glm::ivec2 near = pixel - pixel % kSpacing;
    if (near == pixel) return;
    const bool is_same = paths.rect.Holds(near) && IsOnSurfaceOf(pixel, near);
    paths.ends[paths.rect.Index(pixel)] = is_same ? paths.At(near) : PathOf(pixel, carried);
  });
  return paths;
}

}  // namespace pleinair

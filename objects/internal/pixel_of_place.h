// Which pixel of a view shows a place.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "calib/lens.h"
#include "scene/surface_view.h"

namespace pleinair {

class PixelOfPlace {
 public:
  // Keeps a reference to `view`.
  explicit PixelOfPlace(const SurfaceView& view)
      : view_(view), lens_(view.camera.intrinsics), eye_m_(view.camera.CentreWorldM()) {}

  // None where the place is outside of the picture or something else stands before it.
  std::optional<std::int32_t> operator()(const glm::vec3& place_m) const {
    const glm::dvec3 in_camera(view_.camera.camera_from_world *
                               glm::dvec4(glm::dvec3(place_m), 1.0));
    if (!(in_camera.z > 0.0)) return std::nullopt;
    const std::optional<glm::dvec2> at = lens_.ProjectToPixel(in_camera);
    if (!at) return std::nullopt;
    const auto x = static_cast<int>(std::lround(at->x));
    const auto y = static_cast<int>(std::lround(at->y));
    if (x < 0 || y < 0 || x >= view_.Width() || y >= view_.Height()) return std::nullopt;
    const std::size_t pixel = view_.region.Index(x, y);
    if (view_.region.pixels[pixel] == SurfaceView::kNoRegion) return std::nullopt;
    // Something else may stand before it. Both lie in one pixel, up to its diagonal on a surface
    // that is seen at an angle.
    const glm::vec3& seen_m = view_.position_world_m.pixels[pixel];
    const glm::dvec3 ray = glm::dvec3(seen_m) - eye_m_;
    const double distance_m = glm::length(ray);
    const double cosine =
        std::abs(glm::dot(glm::dvec3(view_.normal_world.pixels[pixel]), ray)) / distance_m;
    const double pixel_m = distance_m / lens_.Intrinsics().fx_px / std::max(cosine, kLeastCosine);
    if (glm::distance(seen_m, place_m) > static_cast<float>(pixel_m) + kNearM) {
      return std::nullopt;
    }
    return static_cast<std::int32_t>(pixel);
  }

 private:
  static constexpr double kLeastCosine = 0.02;
  static constexpr float kNearM = 0.01f;

  const SurfaceView& view_;
  Lens lens_;
  glm::dvec3 eye_m_;
};

}  // namespace pleinair

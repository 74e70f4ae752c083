#include "render/internal/layer_lookup.h"

#include <optional>

#include <glm/common.hpp>

#include "calib/lens.h"
#include "render/internal/view_projection.h"

namespace pleinair {

void LayerLookup::Update(const CameraIntrinsics& camera) {
  if (camera == camera_) return;
  undistorted_ = camera.HasDistortion() ? UndistortedCover(camera) : camera;
  if (camera.HasDistortion()) {
    constexpr float kNowhere = -1e6f;
    lookup_.clear();
    lookup_.reserve(static_cast<std::size_t>(camera.width_px) *
                    static_cast<std::size_t>(camera.height_px));
    for (int y = 0; y < camera.height_px; ++y) {
      for (int x = 0; x < camera.width_px; ++x) {
        const std::optional<glm::dvec3> direction = DirectionFromPixel(camera, {x, y});
        if (!direction || !(direction->z > 0.0)) {
          lookup_.emplace_back(kNowhere);
          continue;
        }
        const glm::dvec2 pixel(
            undistorted_.fx_px * direction->x / direction->z + undistorted_.cx_px,
            undistorted_.fy_px * direction->y / direction->z + undistorted_.cy_px);
        lookup_.emplace_back(WindowFromPixel(pixel));
      }
    }
    texture_ = MakeTexture();
    glBindTexture(GL_TEXTURE_2D, texture_.Name());
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RG32F, camera.width_px, camera.height_px);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTexSubImage2D(
        GL_TEXTURE_2D, 0, 0, 0, camera.width_px, camera.height_px, GL_RG, GL_FLOAT, lookup_.data());
  }
  camera_ = camera;
}

PixelRect LayerLookup::CameraRectOf(const PixelRect& rect) const {
  if (IsIdentity() || rect.Empty()) return rect;
  // A pixel's place is looked up between pixel centres: it may draw from one beside it.
  const glm::vec2 lower = glm::vec2(rect.lower) - 1.0f;
  const glm::vec2 upper = glm::vec2(rect.upper) + 1.0f;
  glm::ivec2 first(camera_.width_px, camera_.height_px);
  glm::ivec2 last(-1);
  std::size_t pixel = 0;
  for (int y = 0; y < camera_.height_px; ++y) {
    for (int x = 0; x < camera_.width_px; ++x, ++pixel) {
      const glm::vec2& place = lookup_[pixel];
      if (place.x < lower.x || place.y < lower.y || place.x > upper.x || place.y > upper.y) {
        continue;
      }
      first = glm::min(first, glm::ivec2(x, y));
      last = glm::max(last, glm::ivec2(x, y));
    }
  }
  if (last.x < 0) return {};
  return {first, last + 1};
}

}  // namespace pleinair

// The picture in the window: where it is, and what is drawn over it.
#pragma once

#include <glm/vec2.hpp>

#include "apps/viewer/view_model.h"

namespace pleinair {

// Where on the screen the picture's pixels are. Integer pixel coordinates are pixel centres.
struct PicturePlace {
  glm::dvec2 origin{0.0};  // Of its upper left corner.
  double scale = 1.0;      // Screen units a pixel.

  glm::dvec2 ToScreen(const glm::dvec2& pixel) const { return origin + scale * (pixel + 0.5); }
  glm::dvec2 ToPixel(const glm::dvec2& screen) const { return (screen - origin) / scale - 0.5; }
};

class PictureView {
 public:
  // Behind all panels; as large as the window's free area allows.
  void Draw(ViewModel& model,
            ViewWindow& window,
            const glm::dvec2& area_origin,
            const glm::dvec2& area_size);
  const PicturePlace& Place() const { return place_; }

 private:
  void DrawSelection(const ViewModel& model);
  void DrawBalls(const ViewModel& model);
  void DrawWindows(const ViewModel& model);
  void DrawMask(const ViewModel& model, const glm::dvec2& low, const glm::dvec2& high);
  void DrawPose(const ViewModel& model);
  // The picture around the pointer, larger.
  void DrawLoupe(const glm::dvec2& pixel);

  PicturePlace place_;
  Texture shown_;
  Texture overlay_;
  Texture balls_;  // One below the other.
  Texture mask_;
  std::optional<std::int64_t> mask_version_;  // Of that texture.
  std::int64_t number_ = 0;                   // Of the frame that the textures are of.
  bool has_overlay_ = false;
};

}  // namespace pleinair

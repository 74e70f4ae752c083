// An IrradianceChange on the device.
#pragma once

#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"
#include "scene/irradiance_change.h"

namespace pleinair {

class ChangeTexture {
 public:
  // Takes this frame's; null or empty: nothing changes. Keeps its memory while it suffices.
  void Update(const IrradianceChange* change);

  // RGB32F; the texel (0, 0) belongs to Rect().lower. Outside Rect() its content is undefined.
  GLuint Texture() const { return texture_.Name(); }
  // Where in the picture there is a change.
  const PixelRect& Rect() const { return rect_; }

 private:
  GlObject texture_;
  glm::ivec2 size_{0};
  PixelRect rect_;
};

}  // namespace pleinair

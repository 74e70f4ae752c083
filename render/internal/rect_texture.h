// Values over part of a picture, on the device.
#pragma once

#include <epoxy/gl.h>
#include <glm/vec4.hpp>

#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"
#include "scene/image.h"

namespace pleinair {

class RectTexture {
 public:
  // Uploads this frame's values; an empty image means none. Keeps its memory while it is large
  // enough. One instance is for images of one kind.
  void Update(const glm::ivec2& lower, const RgbImage& image);
  void Update(const glm::ivec2& lower, const GrayImage& image);
  void Update(const glm::ivec2& lower, const Image<glm::vec4>& image);
  void Clear() { rect_ = {}; }

  // RGB32F, R32F or RGBA32F; the texel (0, 0) belongs to Rect().lower. Outside Rect() its content
  // is undefined.
  GLuint Texture() const { return texture_.Name(); }
  // Where in the picture there are values.
  const PixelRect& Rect() const { return rect_; }

 private:
  void Upload(const glm::ivec2& lower,
              const glm::ivec2& size,
              GLenum internal_format,
              GLenum format,
              const void* values);

  GlObject texture_;
  glm::ivec2 size_{0};
  PixelRect rect_;
};

}  // namespace pleinair

// Values over part of a picture, on the device.
#pragma once

#include <span>

#include <epoxy/gl.h>
#include <glm/common.hpp>
#include <glm/vec2.hpp>

#include "render/internal/screen_extent.h"
#include "render/internal/streamed_texture.h"
#include "scene/image.h"

namespace pleinair {

template <typename Texel>
class RectTexture {
 public:
  // Uploads this frame's values; texel_of(value) returns the texel. An empty image means none.
  // Keeps its memory while it is large enough.
  template <typename Value, typename TexelOf>
  void Update(const glm::ivec2& lower, const Image<Value>& image, const TexelOf& texel_of) {
    Clear();
    const glm::ivec2 size(image.width, image.height);
    if (size.x == 0 || size.y == 0) return;
    rect_ = {lower, lower + size};
    if (size.x > size_.x || size.y > size_.y) {
      size_ = glm::max(size_, size);
      texture_.Make(size_);
    }
    texture_.Fill({glm::ivec2(0), size}, [&](int, int y, std::span<Texel> texels) {
      const Value* value = &image.At(0, y);
      for (Texel& texel : texels) texel = texel_of(*value++);
    });
  }
  void Update(const glm::ivec2& lower, const Image<Texel>& image) {
    Update(lower, image, [](const Texel& texel) { return texel; });
  }
  void Clear() { rect_ = {}; }

  // The texel (0, 0) belongs to Rect().lower. Outside Rect() its content is undefined.
  GLuint Texture() const { return texture_.Name(); }
  // Where in the picture there are values.
  const PixelRect& Rect() const { return rect_; }

 private:
  StreamedTexture<Texel> texture_;
  glm::ivec2 size_{0};
  PixelRect rect_;
};

}  // namespace pleinair

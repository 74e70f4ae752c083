#include "render/internal/rect_texture.h"

#include <glm/common.hpp>

namespace pleinair {

void RectTexture::Update(const glm::ivec2& lower, const RgbImage& image) {
  Upload(lower, {image.width, image.height}, GL_RGB32F, GL_RGB, image.pixels.data());
}

void RectTexture::Update(const glm::ivec2& lower, const GrayImage& image) {
  Upload(lower, {image.width, image.height}, GL_R32F, GL_RED, image.pixels.data());
}

void RectTexture::Update(const glm::ivec2& lower, const Image<glm::vec4>& image) {
  Upload(lower, {image.width, image.height}, GL_RGBA32F, GL_RGBA, image.pixels.data());
}

void RectTexture::Upload(const glm::ivec2& lower,
                         const glm::ivec2& size,
                         GLenum internal_format,
                         GLenum format,
                         const void* values) {
  Clear();
  if (size.x == 0 || size.y == 0) return;
  rect_ = {lower, lower + size};
  if (size.x > size_.x || size.y > size_.y) {
    size_ = glm::max(size_, size);
    texture_ = MakeTexture();
    glBindTexture(GL_TEXTURE_2D, texture_.Name());
    glTexStorage2D(GL_TEXTURE_2D, 1, internal_format, size_.x, size_.y);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  glBindTexture(GL_TEXTURE_2D, texture_.Name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.x, size.y, format, GL_FLOAT, values);
}

}  // namespace pleinair

#include "render/internal/change_texture.h"

#include <glm/common.hpp>

namespace pleinair {

void ChangeTexture::Update(const IrradianceChange* change) {
  rect_ = {};
  if (change == nullptr || change->irradiance_rgb.Empty()) return;
  const RgbImage& image = change->irradiance_rgb;
  rect_.lower = {change->x_px, change->y_px};
  rect_.upper = rect_.lower + glm::ivec2(image.width, image.height);
  if (image.width > size_.x || image.height > size_.y) {
    size_ = glm::max(size_, glm::ivec2(image.width, image.height));
    texture_ = MakeTexture();
    glBindTexture(GL_TEXTURE_2D, texture_.Name());
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGB32F, size_.x, size_.y);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  glBindTexture(GL_TEXTURE_2D, texture_.Name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(
      GL_TEXTURE_2D, 0, 0, 0, image.width, image.height, GL_RGB, GL_FLOAT, image.pixels.data());
}

}  // namespace pleinair

#include "render/internal/surface_textures.h"

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

namespace pleinair {
namespace {

GlObject MakeNearestTexture(GLenum format, int width, int height) {
  GlObject texture = MakeTexture();
  glBindTexture(GL_TEXTURE_2D, texture.Name());
  glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

template <typename Pixel>
void Upload(const GlObject& texture,
            const glm::ivec2& size,
            GLenum format,
            GLenum type,
            const std::vector<Pixel>& pixels) {
  glBindTexture(GL_TEXTURE_2D, texture.Name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.x, size.y, format, type, pixels.data());
}

}  // namespace

void SurfaceTextures::Update(const SurfaceView& view) {
  const Size size{view.Width(), view.Height(), static_cast<int>(view.sky_response.size())};
  const glm::ivec2 pixels(size.width, size.height);
  const bool is_resized = !(size == size_);
  if (is_resized) {
    albedo_ = MakeNearestTexture(GL_RGBA32F, size.width, size.height);
    normal_ = MakeNearestTexture(GL_RGB32F, size.width, size.height);
    sun_bounce_ = MakeNearestTexture(GL_RGB32F, size.width, size.height);
    sun_visibility_ = MakeNearestTexture(GL_RG32F, size.width, size.height);
    sky_response_ = MakeTexture();
    glBindTexture(GL_TEXTURE_2D_ARRAY, sky_response_.Name());
    glTexStorage3D(GL_TEXTURE_2D_ARRAY,
                   1,
                   GL_RGB32F,
                   size.width,
                   size.height,
                   size.sky_shapes > 0 ? size.sky_shapes : 1);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    size_ = size;
  }
  if (is_resized || view.geometry_version != geometry_version_ ||
      view.albedo_rgb.pixels.data() != geometry_data_) {
    std::vector<glm::vec4> albedo(view.albedo_rgb.pixels.size());
    for (std::size_t i = 0; i < albedo.size(); ++i) {
      albedo[i] =
          glm::vec4(view.albedo_rgb.pixels[i], view.albedo_measured.pixels[i] != 0 ? 1.0f : 0.0f);
    }
    Upload(albedo_, pixels, GL_RGBA, GL_FLOAT, albedo);
    Upload(normal_, pixels, GL_RGB, GL_FLOAT, view.normal_world.pixels);
    geometry_version_ = view.geometry_version;
    geometry_data_ = view.albedo_rgb.pixels.data();
  }
  const void* sky_data =
      view.sky_response.empty() ? nullptr : view.sky_response.front().pixels.data();
  if (is_resized || view.sky_version != sky_version_ || sky_data != sky_data_) {
    glBindTexture(GL_TEXTURE_2D_ARRAY, sky_response_.Name());
    for (int k = 0; k < size.sky_shapes; ++k) {
      glTexSubImage3D(GL_TEXTURE_2D_ARRAY,
                      0,
                      0,
                      0,
                      k,
                      size.width,
                      size.height,
                      1,
                      GL_RGB,
                      GL_FLOAT,
                      view.sky_response[static_cast<std::size_t>(k)].pixels.data());
    }
    sky_version_ = view.sky_version;
    sky_data_ = sky_data;
  }
  if (is_resized || view.sun_version != sun_version_ ||
      view.sun_visibility.pixels.data() != sun_data_) {
    std::vector<glm::vec2> visibility(view.sun_visibility.pixels.size());
    for (std::size_t i = 0; i < visibility.size(); ++i) {
      visibility[i] = {view.sun_visibility.pixels[i], view.edge_distance_px.pixels[i]};
    }
    Upload(sun_visibility_, pixels, GL_RG, GL_FLOAT, visibility);
    Upload(sun_bounce_, pixels, GL_RGB, GL_FLOAT, view.sun_bounce.pixels);
    sun_version_ = view.sun_version;
    sun_data_ = view.sun_visibility.pixels.data();
  }
}

void SurfaceTextures::UpdateCamera(const RgbImage& radiance, const Gray8Image& clipped) {
  const Size size{radiance.width, radiance.height, 0};
  const glm::ivec2 pixels(radiance.width, radiance.height);
  if (!(size == camera_size_)) {
    camera_ = MakeNearestTexture(GL_RGB32F, size.width, size.height);
    clipped_ = MakeNearestTexture(GL_R8, size.width, size.height);
    camera_size_ = size;
  }
  Upload(camera_, pixels, GL_RGB, GL_FLOAT, radiance.pixels);
  if (clipped.Empty()) {
    const std::vector<std::uint8_t> none(radiance.pixels.size(), 0);
    Upload(clipped_, pixels, GL_RED, GL_UNSIGNED_BYTE, none);
  } else {
    Upload(clipped_, pixels, GL_RED, GL_UNSIGNED_BYTE, clipped.pixels);
  }
}

}  // namespace pleinair

// A texture that is filled anew in every frame, from the processor's memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>

#include <epoxy/gl.h>
#include <tbb/parallel_for.h>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"

namespace pleinair {

// How OpenGL names a type's texels. There are none of three channels, which drivers would have to
// widen one by one.
template <typename Texel>
struct TexelFormat;
template <>
struct TexelFormat<glm::vec4> {
  static constexpr GLenum kInternal = GL_RGBA32F;
  static constexpr GLenum kFormat = GL_RGBA;
  static constexpr GLenum kType = GL_FLOAT;
};
template <>
struct TexelFormat<glm::vec2> {
  static constexpr GLenum kInternal = GL_RG32F;
  static constexpr GLenum kFormat = GL_RG;
  static constexpr GLenum kType = GL_FLOAT;
};
template <>
struct TexelFormat<float> {
  static constexpr GLenum kInternal = GL_R32F;
  static constexpr GLenum kFormat = GL_RED;
  static constexpr GLenum kType = GL_FLOAT;
};
template <>
struct TexelFormat<std::uint8_t> {
  static constexpr GLenum kInternal = GL_R8;
  static constexpr GLenum kFormat = GL_RED;
  static constexpr GLenum kType = GL_UNSIGNED_BYTE;
};

// An array of textures, looked up by nearest texel. All threads write texels into memory that the
// device reads: with a GPU, copies by one thread would take longer than anything that it draws.
template <typename Texel>
class StreamedTexture {
 public:
  // GL_TEXTURE_2D, of one layer, or GL_TEXTURE_2D_ARRAY.
  explicit StreamedTexture(GLenum target = GL_TEXTURE_2D) : target_(target) {}

  // Makes another texture, whose content is undefined.
  void Make(const glm::ivec2& size, int layers = 1) {
    layers_ = layers;
    texture_ = MakeTexture();
    glBindTexture(target_, texture_.Name());
    if (target_ == GL_TEXTURE_2D) {
      glTexStorage2D(target_, 1, TexelFormat<Texel>::kInternal, size.x, size.y);
    } else {
      glTexStorage3D(target_, 1, TexelFormat<Texel>::kInternal, size.x, size.y, layers);
    }
    glTexParameteri(target_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(target_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }

  // Fills a part that is not empty. fill_row(layer, y, texels) writes the texels of `rect` in row
  // y, on any thread. Throws std::runtime_error where the device has no memory for them.
  template <typename FillRow>
  void Fill(const PixelRect& rect, const FillRow& fill_row) {
    const std::size_t count = static_cast<std::size_t>(layers_) * rect.Count();
    if (!buffer_) buffer_ = MakeBuffer();
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer_.Name());
    const auto bytes = static_cast<GLsizeiptr>(count * sizeof(Texel));
    if (bytes > buffer_bytes_) {
      glBufferData(GL_PIXEL_UNPACK_BUFFER, bytes, nullptr, GL_STREAM_DRAW);
      buffer_bytes_ = bytes;
    }
    do {
      void* const memory = glMapBufferRange(
          GL_PIXEL_UNPACK_BUFFER, 0, bytes, GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
      if (memory == nullptr) {
        glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
        throw std::runtime_error("compositor: the device has no memory for a picture");
      }
      const std::span<Texel> texels(static_cast<Texel*>(memory), count);
      const auto width = static_cast<std::size_t>(rect.Width());
      tbb::parallel_for(0, layers_ * rect.Height(), [&](int row) {
        fill_row(row / rect.Height(),
                 rect.lower.y + row % rect.Height(),
                 texels.subspan(static_cast<std::size_t>(row) * width, width));
      });
      // False where the system took the memory away meanwhile.
    } while (glUnmapBuffer(GL_PIXEL_UNPACK_BUFFER) == GL_FALSE);
    glBindTexture(target_, texture_.Name());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    constexpr GLenum kFormat = TexelFormat<Texel>::kFormat;
    constexpr GLenum kType = TexelFormat<Texel>::kType;
    const glm::ivec2& at = rect.lower;
    if (target_ == GL_TEXTURE_2D) {
      glTexSubImage2D(target_, 0, at.x, at.y, rect.Width(), rect.Height(), kFormat, kType, nullptr);
    } else {
      glTexSubImage3D(
          target_, 0, at.x, at.y, 0, rect.Width(), rect.Height(), layers_, kFormat, kType, nullptr);
    }
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  }

  GLuint Name() const { return texture_.Name(); }

 private:
  GLenum target_;
  GlObject texture_;
  GlObject buffer_;
  int layers_ = 1;
  GLsizeiptr buffer_bytes_ = 0;
};

}  // namespace pleinair

// A texture that is refilled each frame, from the processor's memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <utility>

#include <epoxy/gl.h>
#include <tbb/parallel_for.h>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "render/internal/gl_object.h"
#include "render/internal/screen_extent.h"

namespace pleinair {

// How OpenGL names texels of floats. There are none of three channels, which drivers would have to
// widen one by one.
template <typename Texel>
struct TexelFormat;
template <>
struct TexelFormat<glm::vec4> {
  static constexpr GLenum kInternal = GL_RGBA32F;
  static constexpr GLenum kFormat = GL_RGBA;
};
template <>
struct TexelFormat<glm::vec2> {
  static constexpr GLenum kInternal = GL_RG32F;
  static constexpr GLenum kFormat = GL_RG;
};
template <>
struct TexelFormat<float> {
  static constexpr GLenum kInternal = GL_R32F;
  static constexpr GLenum kFormat = GL_RED;
};
// Memory that the device reads texels from, bound as GL_PIXEL_UNPACK_BUFFER during its life.
class UnpackMemory {
 public:
  explicit UnpackMemory(const GlObject& buffer) {
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffer.Name());
  }
  ~UnpackMemory() {
    if (is_mapped_) glUnmapBuffer(GL_PIXEL_UNPACK_BUFFER);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  }
  UnpackMemory(const UnpackMemory&) = delete;
  UnpackMemory& operator=(const UnpackMemory&) = delete;

  // Null where the device gives none.
  void* Map(GLsizeiptr bytes) {
    void* const memory = glMapBufferRange(
        GL_PIXEL_UNPACK_BUFFER, 0, bytes, GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_BUFFER_BIT);
    is_mapped_ = memory != nullptr;
    return memory;
  }
  // False where the system has discarded what was written.
  bool Unmap() {
    is_mapped_ = false;
    return glUnmapBuffer(GL_PIXEL_UNPACK_BUFFER) == GL_TRUE;
  }

 private:
  bool is_mapped_ = false;
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

  // Fills a part that is not empty, of every layer. fill_row(layer, y, texels) writes the texels of
  // `rect` in row y, on any thread. Throws std::runtime_error where the device gives no memory.
  template <typename FillRow>
  void Fill(const PixelRect& rect, const FillRow& fill_row) {
    if (!buffer_) buffer_ = MakeBuffer();
    UnpackMemory memory(buffer_);
    glBindTexture(target_, texture_.Name());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (int layer = 0; layer < layers_; ++layer) {
      Write(memory, rect, [&](int y, std::span<Texel> texels) { fill_row(layer, y, texels); });
      CopyToTexture(rect, layer);
    }
  }

  GLuint Name() const { return texture_.Name(); }

 private:
  template <typename FillRow>
  void Write(UnpackMemory& memory, const PixelRect& rect, const FillRow& fill_row) {
    const auto bytes = static_cast<GLsizeiptr>(rect.Count() * sizeof(Texel));
    constexpr int kTries = 3;
    for (int i = 0; i < kTries; ++i) {
      if (bytes > buffer_bytes_) {
        glBufferData(GL_PIXEL_UNPACK_BUFFER, bytes, nullptr, GL_STREAM_DRAW);
      }
      void* const mapped = memory.Map(bytes);
      if (mapped == nullptr) {
        buffer_bytes_ = 0;
        break;
      }
      buffer_bytes_ = std::max(buffer_bytes_, bytes);
      const std::span<Texel> texels(static_cast<Texel*>(mapped), rect.Count());
      const auto width = static_cast<std::size_t>(rect.Width());
      tbb::parallel_for(0, rect.Height(), [&](int row) {
        fill_row(rect.lower.y + row, texels.subspan(static_cast<std::size_t>(row) * width, width));
      });
      if (memory.Unmap()) return;
    }
    throw std::runtime_error(
        "compositor: this device gives no memory for a picture's data: it has no more, or the "
        "OpenGL context has been lost");
  }

  // From the bound memory to the bound texture.
  void CopyToTexture(const PixelRect& rect, int layer) const {
    constexpr GLenum kFormat = TexelFormat<Texel>::kFormat;
    const auto [x, y] = std::pair{rect.lower.x, rect.lower.y};
    const auto [width, height] = std::pair{rect.Width(), rect.Height()};
    if (target_ == GL_TEXTURE_2D) {
      glTexSubImage2D(target_, 0, x, y, width, height, kFormat, GL_FLOAT, nullptr);
    } else {
      glTexSubImage3D(target_, 0, x, y, layer, width, height, 1, kFormat, GL_FLOAT, nullptr);
    }
  }

  GLenum target_;
  GlObject texture_;
  GlObject buffer_;
  int layers_ = 1;
  GLsizeiptr buffer_bytes_ = 0;
};

}  // namespace pleinair

#include "render/internal/layer_reader.h"

#include <glm/gtc/packing.hpp>

namespace pleinair {
namespace {

void ReadInto(
    const FrameBuffer& frame, const PixelRect& rect, GLenum format, GLenum type, void* values) {
  frame.BindForReading();
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(rect.lower.x, rect.lower.y, rect.Width(), rect.Height(), format, type, values);
}

}  // namespace

std::span<const std::uint16_t> LayerReader::ReadHalves(const FrameBuffer& frame,
                                                       const PixelRect& rect) {
  halves_.resize(4 * rect.Count());
  frame.BindForReading();
  GLint format = 0;
  GLint type = 0;
  glGetIntegerv(GL_IMPLEMENTATION_COLOR_READ_FORMAT, &format);
  glGetIntegerv(GL_IMPLEMENTATION_COLOR_READ_TYPE, &type);
  if (epoxy_is_desktop_gl() || (format == GL_RGBA && type == GL_HALF_FLOAT)) {
    ReadInto(frame, rect, GL_RGBA, GL_HALF_FLOAT, halves_.data());
    return halves_;
  }
  const std::span<const glm::vec4> floats = ReadFloats(frame, rect);
  for (std::size_t i = 0; i < halves_.size(); ++i) {
    halves_[i] = glm::packHalf1x16(floats[i / 4][static_cast<int>(i % 4)]);
  }
  return halves_;
}

std::span<const glm::vec4> LayerReader::ReadFloats(const FrameBuffer& frame,
                                                   const PixelRect& rect) {
  floats_.resize(rect.Count());
  ReadInto(frame, rect, GL_RGBA, GL_FLOAT, floats_.data());
  return floats_;
}

std::span<const std::uint8_t> LayerReader::ReadBytes(const FrameBuffer& frame,
                                                     const PixelRect& rect) {
  // Every device reads this format.
  bytes_.resize(4 * rect.Count());
  ReadInto(frame, rect, GL_RGBA, GL_UNSIGNED_BYTE, bytes_.data());
  const std::size_t count = rect.Count();
  for (std::size_t i = 0; i < count; ++i) bytes_[i] = bytes_[4 * i];
  return std::span(bytes_).first(count);
}

std::span<const std::uint32_t> LayerReader::ReadNumbers(const FrameBuffer& frame,
                                                        const PixelRect& rect) {
  numbers_.resize(rect.Count());
  ReadInto(frame, rect, GL_RED_INTEGER, GL_UNSIGNED_INT, numbers_.data());
  return numbers_;
}

}  // namespace pleinair

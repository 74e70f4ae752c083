// Reads frame buffers back into memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec4.hpp>

#include "render/internal/frame_buffer.h"

namespace pleinair {

// Results are valid until the next call.
class LayerReader {
 public:
  // `rect` of an RGBA16F frame buffer, four half floats a pixel; in its own format where the device
  // can.
  std::span<const std::uint16_t> ReadHalves(const FrameBuffer& frame, const PixelRect& rect);
  // `rect` of an RGBA16F or RGBA32F one, in row-major order.
  std::span<const glm::vec4> ReadFloats(const FrameBuffer& frame, const PixelRect& rect);
  // The red of `rect` of an R8 one.
  std::span<const std::uint8_t> ReadBytes(const FrameBuffer& frame, const PixelRect& rect);
  // `rect` of an R32UI one. Desktop OpenGL only.
  std::span<const std::uint32_t> ReadNumbers(const FrameBuffer& frame, const PixelRect& rect);

 private:
  std::vector<std::uint16_t> halves_;
  std::vector<glm::vec4> floats_;
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint32_t> numbers_;
};

}  // namespace pleinair

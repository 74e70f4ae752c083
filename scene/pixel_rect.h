// A rectangle of a picture's pixels.
#pragma once

#include <cstddef>

#include <glm/common.hpp>
#include <glm/vec2.hpp>

namespace pleinair {

// Pixels lower <= (x, y) < upper; empty where upper <= lower.
struct PixelRect {
  glm::ivec2 lower{0};
  glm::ivec2 upper{0};

  bool Empty() const { return upper.x <= lower.x || upper.y <= lower.y; }
  int Width() const { return upper.x - lower.x; }
  int Height() const { return upper.y - lower.y; }
  std::size_t Count() const {
    return Empty() ? 0 : static_cast<std::size_t>(Width()) * static_cast<std::size_t>(Height());
  }
  bool Holds(const glm::ivec2& pixel) const {
    return pixel.x >= lower.x && pixel.y >= lower.y && pixel.x < upper.x && pixel.y < upper.y;
  }
  // Index of a pixel inside, in row-major order.
  std::size_t Index(const glm::ivec2& pixel) const {
    return static_cast<std::size_t>(pixel.y - lower.y) * static_cast<std::size_t>(Width()) +
           static_cast<std::size_t>(pixel.x - lower.x);
  }
  bool operator==(const PixelRect&) const = default;
};

// The smallest rectangle that holds both.
inline PixelRect UnionOf(const PixelRect& a, const PixelRect& b) {
  if (a.Empty()) return b;
  if (b.Empty()) return a;
  return {glm::min(a.lower, b.lower), glm::max(a.upper, b.upper)};
}

}  // namespace pleinair

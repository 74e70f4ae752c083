#include "scene/half_float.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace pleinair {
namespace {

// Positive floats, infinity and NaN have the order of their bits.
std::int32_t MagnitudeBits(float value) { return std::bit_cast<std::int32_t>(value) & 0x7fffffff; }

}  // namespace

std::int64_t ClampToHalf(RgbImage& image) {
  std::int64_t clamped = 0;
  for (glm::vec3& pixel : image.pixels) {
    const std::int32_t largest =
        std::max({MagnitudeBits(pixel.r), MagnitudeBits(pixel.g), MagnitudeBits(pixel.b)});
    if (largest <= std::bit_cast<std::int32_t>(kLargestHalf)) continue;
    bool is_beyond = false;
    for (int channel = 0; channel < 3; ++channel) {
      float& value = pixel[channel];
      if (!(std::abs(value) > kLargestHalf) || std::isinf(value)) continue;
      value = std::copysign(kLargestHalf, value);
      is_beyond = true;
    }
    clamped += is_beyond ? 1 : 0;
  }
  return clamped;
}

}  // namespace pleinair

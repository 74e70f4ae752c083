#include "scene/half_float.h"

#include <cmath>

namespace pleinair {

std::int64_t ClampToHalf(RgbImage& image) {
  std::int64_t clamped = 0;
  for (glm::vec3& pixel : image.pixels) {
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

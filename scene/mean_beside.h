// What a pixel without a value takes from those around it.
#pragma once

#include <optional>

#include "scene/image.h"

namespace pleinair {

// The mean of the up to nine pixels in and around (x, y) for which `is_known(x, y)` holds; none
// where there is none. Is asked for pixels inside the image only.
template <typename Value, typename IsKnown>
std::optional<Value> MeanBeside(const Image<Value>& image, int x, int y, const IsKnown& is_known) {
  Value sum(0.0f);
  int count = 0;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (!image.Contains(u, v) || !is_known(u, v)) continue;
      sum += image.At(u, v);
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<float>(count);
}

}  // namespace pleinair

// The range of half floats, as of a written composite.
#pragma once

#include <cstdint>

#include "scene/image.h"

namespace pleinair {

inline constexpr float kLargestHalf = 65504.0f;

// Sets finite values beyond +-kLargestHalf to it, and returns how many pixels had one. NaN and
// infinities stay: half floats hold them.
std::int64_t ClampToHalf(RgbImage& image);

}  // namespace pleinair

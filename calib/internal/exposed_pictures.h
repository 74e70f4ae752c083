// Common checks of exposure brackets.
#pragma once

#include <array>
#include <span>

#include "calib/exposure_merge.h"

namespace pleinair {

inline constexpr std::array<const char*, 3> kChannelNames{"red", "green", "blue"};

// Throws std::invalid_argument naming the picture: none at all, an exposure that is not positive,
// another size than the first's.
void RequireSameView(std::span<const ExposedPicture> pictures);

}  // namespace pleinair

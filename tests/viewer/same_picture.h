// Whether two pictures show the same.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include <gtest/gtest.h>

#include "scene/image.h"

namespace pleinair {

// One code value in a pixel of a hundred thousand: light that is read from its decimals is summed
// in another order than light that was just estimated.
inline testing::AssertionResult IsTheSameButForRounding(const Rgb8Image& a, const Rgb8Image& b) {
  if (a.width != b.width || a.height != b.height) {
    return testing::AssertionFailure() << "the sizes differ";
  }
  std::size_t different = 0;
  int most = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    different += a.pixels[i] != b.pixels[i] ? 1 : 0;
    for (int c = 0; c < 3; ++c) {
      most = std::max(most, std::abs(int{a.pixels[i][c]} - int{b.pixels[i][c]}));
    }
  }
  if (most <= 1 && different <= 1 + a.pixels.size() / 100000) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << different << " pixels differ, by up to " << most << " code values";
}

}  // namespace pleinair

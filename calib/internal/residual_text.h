// Residuals in messages.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace pleinair {

inline std::string PixelText(double value_px) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.2f px", value_px);
  return text.data();
}

}  // namespace pleinair

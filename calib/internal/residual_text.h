// Residuals and other numbers in messages.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace pleinair {

inline std::string NumberText(const char* format, double value) {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

inline std::string PixelText(double value_px) { return NumberText("%.2f px", value_px); }

}  // namespace pleinair

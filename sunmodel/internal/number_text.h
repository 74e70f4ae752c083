// Numbers in error messages.
#pragma once

#include <array>
#include <charconv>
#include <stdexcept>
#include <string>

namespace pleinair {

// Short, and exact enough to be found again.
inline std::string NumberText(double value) {
  std::array<char, 32> text{};
  const auto result =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 12);
  return {text.data(), result.ptr};
}

// Throws std::invalid_argument naming `field` and its value where that is NaN or out of range.
inline void CheckRange(const std::string& field, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw std::invalid_argument(field + " is " + NumberText(value) + ", expected " +
                              NumberText(least) + " to " + NumberText(most));
}

}  // namespace pleinair

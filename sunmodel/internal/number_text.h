// A number as an error message shows it: short, and exact enough to be found again.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace pleinair {

inline std::string NumberText(double value) {
  std::array<char, 32> text{};
  const auto result =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 12);
  return {text.data(), result.ptr};
}

}  // namespace pleinair

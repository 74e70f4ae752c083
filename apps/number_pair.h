// Pairs of numbers in arguments: "4x16", "135,40".
#pragma once

#include <array>
#include <charconv>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fmt/format.h>

namespace pleinair {

// Two numbers with `separator` between them, and nothing else. Throws std::invalid_argument naming
// `option`.
template <class Number>
std::array<Number, 2> ParsePair(const std::string& text, char separator, const char* option) {
  std::array<Number, 2> pair{};
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, pair[0]);
  const bool separated = first.ec == std::errc() && first.ptr != end && *first.ptr == separator;
  const auto second =
      separated ? std::from_chars(first.ptr + 1, end, pair[1]) : std::from_chars_result{end, {}};
  if (!separated || second.ec != std::errc() || second.ptr != end) {
    throw std::invalid_argument(fmt::format(
        "{} '{}': expected two numbers with '{}' between them", option, text, separator));
  }
  return pair;
}

}  // namespace pleinair

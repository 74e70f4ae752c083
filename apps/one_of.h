// An argument that is one of some words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace pleinair {

// For Option::transform. CLI11's own accepts values' numbers, too, and names all of them in its
// message.
template <typename Value>
CLI::Validator OneOf(const std::vector<std::pair<std::string, Value>>& choices) {
  std::string words;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    words += (i == 0 ? "" : i + 1 == choices.size() ? " or " : ", ") + choices[i].first;
  }
  return CLI::Validator(
      [choices, words](std::string& text) {
        for (const auto& [word, value] : choices) {
          if (word != text) continue;
          text = std::to_string(static_cast<std::int64_t>(value));
          return std::string();
        }
        return "expected " + words + ", found '" + text + "'";
      },
      "");
}

}  // namespace pleinair

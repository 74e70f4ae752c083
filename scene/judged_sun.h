// A person's judgement, from the picture, whether the sun reaches a place.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace pleinair {

enum class JudgedSun : std::uint8_t { kUnknown, kLit, kShaded, kGrazing };

inline constexpr JudgedSun kAllJudgments[] = {
    JudgedSun::kLit, JudgedSun::kShaded, JudgedSun::kGrazing};

// The name in sequence.json; empty for kUnknown, which no key states.
constexpr std::string_view NameOf(JudgedSun sun) {
  switch (sun) {
    case JudgedSun::kLit:
      return "lit";
    case JudgedSun::kShaded:
      return "shaded";
    case JudgedSun::kGrazing:
      return "grazing";
    case JudgedSun::kUnknown:
      break;
  }
  return "";
}

// None where `name` is no judgment's.
constexpr std::optional<JudgedSun> JudgedSunNamed(std::string_view name) {
  for (const JudgedSun sun : kAllJudgments) {
    if (NameOf(sun) == name) return sun;
  }
  return std::nullopt;
}

}  // namespace pleinair

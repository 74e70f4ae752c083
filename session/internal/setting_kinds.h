// Kinds of settings: a number in a range, one of some words, a switch, counts. Each reads its text
// into a field of the options, and describes its values in words.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "session/settings.h"

namespace pleinair::internal {

using Options = SessionOptions;

// Throws std::invalid_argument, one line.
[[noreturn]] inline void Refuse(const Setting& setting, const std::string& text) {
  throw std::invalid_argument(
      fmt::format("{}: expected {}, found '{}'", setting.name, setting.values, text));
}

template <typename Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// A range of numbers; `unit` follows it in messages.
template <typename Number>
struct Range {
  Number least{};
  Number most{};
  std::string unit{};
  bool least_is_excluded = false;

  bool Holds(Number number) const {
    if constexpr (std::is_floating_point_v<Number>) {
      if (!std::isfinite(number)) return false;
    }
    return (least_is_excluded ? number > least : number >= least) && number <= most;
  }
  std::string Words() const {
    const bool open = most == std::numeric_limits<Number>::max();
    std::string words = least_is_excluded ? fmt::format("above {}", least)
                        : open            ? fmt::format("{} or more", least)
                                          : fmt::format("{} to {}", least, most);
    if (least_is_excluded && !open) words += fmt::format(", up to {}", most);
    return unit.empty() ? words : words + " " + unit;
  }
};

template <typename Number>
Range<Number> Between(Number least, Number most, std::string unit = {}) {
  return {least, most, std::move(unit)};
}
template <typename Number>
Range<Number> From(Number least, std::string unit = {}) {
  return {least, std::numeric_limits<Number>::max(), std::move(unit)};
}
template <typename Number>
Range<Number> Above(Number least, std::string unit = {}) {
  return {least, std::numeric_limits<Number>::max(), std::move(unit), true};
}

template <typename Value>
struct Unwrapped {
  using Type = Value;
};
template <typename Value>
struct Unwrapped<std::optional<Value>> {
  using Type = Value;
};

// `field` returns the number in the options. Where that is optional, `standard` describes the value
// used without it.
template <typename Field, typename Number>
Setting NumberSetting(std::string name,
                      std::string meaning,
                      Range<Number> range,
                      Field field,
                      std::string standard = {}) {
  Setting setting{std::move(name), std::move(meaning), range.Words(), std::move(standard), {}};
  using Stored = std::remove_reference_t<decltype(field(std::declval<Options&>()))>;
  if constexpr (std::is_same_v<Stored, Number>) {
    Options defaults;
    setting.standard = fmt::format("{}", field(defaults));
  }
  setting.set = [setting, range, field](const std::string& text, Options& options) {
    const auto number = ParseNumber<Number>(text);
    if (!number || !range.Holds(*number)) Refuse(setting, text);
    field(options) = *number;
  };
  return setting;
}

template <typename Field>
using Choices =
    std::vector<std::pair<std::string,
                          typename Unwrapped<std::remove_reference_t<decltype(std::declval<Field>()(
                              std::declval<Options&>()))>>::Type>>;

// "a, b or c".
inline std::string Listed(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  }
  return text;
}

template <typename Field>
Setting ChoiceSetting(std::string name,
                      std::string meaning,
                      const Field& field,
                      Choices<Field> choices,
                      std::string standard = {}) {
  std::vector<std::string> words;
  for (const auto& choice : choices) words.push_back(choice.first);
  Setting setting{std::move(name), std::move(meaning), Listed(words), std::move(standard), {}};
  if (setting.standard.empty()) {
    Options defaults;
    for (const auto& [word, value] : choices) {
      if (field(defaults) == value) setting.standard = word;
    }
  }
  setting.set = [setting, field, choices = std::move(choices)](const std::string& text,
                                                               Options& options) {
    for (const auto& [word, value] : choices) {
      if (word != text) continue;
      field(options) = value;
      return;
    }
    Refuse(setting, text);
  };
  return setting;
}

template <typename Field>
Setting SwitchSetting(std::string name, std::string meaning, const Field& field) {
  return ChoiceSetting(std::move(name), std::move(meaning), field, {{"on", true}, {"off", false}});
}

// Electrons of the camera's own noise; stating one makes camera_noise_is_known true.
template <typename Field>
Setting NoiseSetting(std::string name, std::string meaning, const Field& field) {
  Setting setting =
      NumberSetting(std::move(name), std::move(meaning), Above(0.0, "electrons"), field);
  setting.set = [read = setting.set](const std::string& text, Options& options) {
    read(text, options);
    options.camera_noise_is_known = true;
  };
  return setting;
}

// "4x16" or "8x8x8": as many whole numbers above 0 as `counts` has, at most `most` each.
template <std::size_t kCount>
std::optional<std::array<int, kCount>> ParseCounts(const std::string& text, int most) {
  std::array<int, kCount> counts{};
  std::string_view rest(text);
  for (std::size_t i = 0; i < kCount; ++i) {
    const std::size_t end = i + 1 < kCount ? rest.find('x') : rest.size();
    if (end == std::string_view::npos) return std::nullopt;
    const auto count = ParseNumber<int>(rest.substr(0, end));
    if (!count || *count < 1 || *count > most) return std::nullopt;
    counts[i] = *count;
    rest.remove_prefix(std::min(rest.size(), end + 1));
  }
  return counts;
}

}  // namespace pleinair::internal

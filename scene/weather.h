// A person's judgement of the sky.
#pragma once

#include <optional>
#include <string_view>

namespace pleinair {

enum class Weather {
  kOvercast,  // No sun, and no shadow.
  kBroken,    // Clouds before the sun at times.
  kClear,
};

inline constexpr Weather kAllWeathers[] = {Weather::kOvercast, Weather::kBroken, Weather::kClear};

// The name in sequence.json and on the command line.
constexpr std::string_view NameOf(Weather weather) {
  switch (weather) {
    case Weather::kOvercast:
      return "overcast";
    case Weather::kBroken:
      return "broken";
    case Weather::kClear:
      break;
  }
  return "clear";
}

// None where `name` is not the name of a weather.
constexpr std::optional<Weather> WeatherNamed(std::string_view name) {
  for (const Weather weather : kAllWeathers) {
    if (NameOf(weather) == name) return weather;
  }
  return std::nullopt;
}

}  // namespace pleinair

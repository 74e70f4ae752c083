#include "apps/picture_times_arguments.h"

#include <cstdint>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "sunmodel/time_text.h"

namespace pleinair {

std::chrono::nanoseconds ParseInterval(const std::string& text, const std::string& option) {
  double number = 0.0;
  std::size_t end = 0;
  try {
    number = std::stod(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  const std::string unit = text.substr(end);
  const double unit_s = unit.empty() || unit == "s" ? 1.0
                        : unit == "min"             ? 60.0
                        : unit == "h"               ? 3600.0
                                                    : 0.0;
  constexpr double kLongestS = 86400.0;
  const double seconds = number * unit_s;
  // A nanosecond is the clock's unit.
  if (end == 0 || !(seconds >= 1e-9) || !(seconds <= kLongestS)) {
    throw std::invalid_argument(option + " '" + text +
                                "': expected a time above 0, of a day at most: 10s, 2min, 1h");
  }
  return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * seconds));
}

void AddPictureTimes(CLI::App& command, PictureTimes& times, const std::string& group) {
  command
      .add_option_function<std::string>(
          "--start-time",
          [&times](const std::string& text) { times.start = ParseUtcTime(text); },
          "UTC of the first picture of a video or a folder, ISO 8601 (default: as the files say)")
      ->type_name("TIME")
      ->group(group);
  command
      .add_option("--time-zone",
                  times.utc_offset,
                  "of a folder's EXIF times that state none: Z, or such as +02:00")
      ->type_name("OFFSET")
      ->group(group);
  command
      .add_option_function<std::string>(
          "--every",
          [&times](const std::string& text) { times.interval = ParseInterval(text, "--every"); },
          "with --start-time: time from a folder's picture to the next, such as 10s or 2min")
      ->type_name("TIME")
      ->group(group);
}

}  // namespace pleinair

// `pleinair sun`: sun and clear-sky light at a place and a time.
#pragma once

#include <optional>
#include <string>

namespace pleinair {

struct SunCommandOptions {
  std::string site;  // As ParseSite takes it: LAT,LON or LAT,LON,H in degrees and metres.
  std::string time;  // As ParseUtcTime takes it.
  std::optional<double> ut1_minus_utc_s;
  std::optional<double> tt_minus_ut1_s;  // Delta T.
  std::optional<double> pressure_hpa;    // Not given: the standard atmosphere at the site's height.
  std::optional<double> temperature_c;   // The same.
  bool json = false;
};

// Returns what is to be printed, with its last line end: a table, or one JSON object.
// Throws std::invalid_argument, one line that names the argument, on bad input.
std::string RunSunCommand(const SunCommandOptions& options);

// Returns the warning to print beside the answer, when there is one: a year outside the ephemeris's
// own span. The JSON object has it too. Throws as RunSunCommand.
std::optional<std::string> SunCommandWarning(const SunCommandOptions& options);

}  // namespace pleinair

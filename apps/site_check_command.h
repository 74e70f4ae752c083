// `pleinair site check`: what is wrong with a site, and how accurately its light will be known,
// hour by hour.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "session/check/site_forecast.h"
#include "session/check/site_warning.h"
#include "session/session_options.h"

namespace pleinair {

struct SiteCheckOptions {
  SessionOptions session;  // Its `sequence` is the site.
  std::string day;         // YYYY-MM-DD; empty: the first frame's, of a site today.
  int step_min = 60;
  std::filesystem::path out;  // Folder for pictures; empty: none.
  bool json = false;
};

struct SiteCheckReport {
  std::string name;
  SiteWarnings warnings;
  std::optional<SiteDay> day;  // None where warnings make it meaningless.
  std::string why_no_day;
};

SiteCheckReport CheckSiteAndDay(const SiteCheckOptions& options);

// The report to print. Writes <out>/day.png. `is_good`: no warnings. Throws std::runtime_error or
// std::invalid_argument, one line.
std::string RunSiteCheck(const SiteCheckOptions& options, bool* is_good);

}  // namespace pleinair

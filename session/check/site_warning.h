// A warning about a site, for a person to act on.
#pragma once

#include <string>
#include <vector>

namespace pleinair {

// Each field is a text of one line.
struct SiteWarning {
  std::string what;      // "the mesh is not in metres"
  std::string where;     // File, key or frame.
  std::string evidence;  // The evidence, with figures.
  std::string remedy;    // What to do.
  // True for a mesh or camera that is unusable: a forecast of its hours would be useless.
  bool spoils_forecast = false;
};

using SiteWarnings = std::vector<SiteWarning>;

// For a run's notes: "where: what: evidence; remedy".
inline std::string InOneLine(const SiteWarning& warning) {
  return warning.where + ": " + warning.what + ": " + warning.evidence + "; " + warning.remedy;
}

}  // namespace pleinair

// What is wrong with a site, or looks so: for a person to act on.
#pragma once

#include <string>
#include <vector>

namespace pleinair {

// Each a text of one line.
struct SiteWarning {
  std::string what;      // "the mesh is not in metres"
  std::string where;     // File, key or frame.
  std::string evidence;  // How this is known, with figures.
  std::string remedy;    // What to do.
  // Of a mesh or camera that is not what is meant: its hours would be of no use.
  bool spoils_forecast = false;
};

using SiteWarnings = std::vector<SiteWarning>;

}  // namespace pleinair

// `pleinair site place`: a virtual object put onto a real surface, and written to the site.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace pleinair {

struct SitePlaceOptions {
  std::filesystem::path folder;
  std::string object;  // An index into the site's objects, or a mesh file.
  // Either a place in the picture (x, y), or a point of the world; neither: the object stays.
  std::vector<double> pixel;
  std::vector<double> at_m;
  int frame = 0;
  double turn_deg = 0.0;
  double lift_m = 0.0;
  double scale = 1.0;
  bool remove = false;
};

// Writes the site's file, completely or not at all, and returns what was done. Throws
// std::runtime_error or std::invalid_argument, one line; then the site is as it was.
std::string RunSitePlace(const SitePlaceOptions& options);

}  // namespace pleinair

// `pleinair calibrate markers`: where markers stand, from pictures of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pleinair {

struct CalibrateMarkersOptions {
  std::vector<std::filesystem::path> pictures;
  std::filesystem::path camera;  // A sequence.json with the lens, or its folder.
  std::string dictionary = "apriltag_36h11";
  double size_m = 0.0;           // Length of the black border's side.
  std::optional<int> reference;  // Id of the marker that is the world's origin; none: most seen.
  std::filesystem::path anchor;  // A board file that says where some of the markers stand.
  std::filesystem::path out;
};
// Writes the board file, completely or not at all, and returns the report to print. Throws
// std::runtime_error or std::invalid_argument, one line.
std::string RunCalibrateMarkers(const CalibrateMarkersOptions& options);

}  // namespace pleinair

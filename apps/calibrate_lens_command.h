// `pleinair calibrate lens` (and `fisheye`): a lens from pictures of a board.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/lens_fit.h"

namespace pleinair {

struct CalibrateLensOptions {
  std::vector<std::filesystem::path> pictures;
  std::vector<std::filesystem::path> always_used;  // Pictures used whatever their blur and fit.
  std::string board;                               // "8x6": inner corners.
  bool charuco = false;                            // It has markers in its white squares.
  CharucoMarkers markers;                          // The markers of a ChArUco board.
  std::optional<LensModel> model;  // None: the one that predicts held-out pictures better.
  std::optional<double> fov_deg;   // A fish-eye's; none: what the picture shows.
  bool force = false;              // Write a lens that is in doubt, too.
  // At least one of:
  std::filesystem::path out;   // A fish-eye's file, or {"camera": ...}.
  std::filesystem::path site;  // Folder or file whose `camera` or `fisheye` it becomes.
};

// The report to print: each picture's error, those left out with the reason, and the lens. Throws
// std::runtime_error or std::invalid_argument, one line: also where the lens is in doubt
// (DoubtAbout), naming the size of board that fits, if one does.
std::string RunCalibrateLens(const CalibrateLensOptions& options);

}  // namespace pleinair

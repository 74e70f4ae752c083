// `pleinair calibrate markers`: where markers stand, from pictures of them; and `pleinair calibrate
// pose`: where the camera stood in each frame of a sequence, from the markers in it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/frame_source.h"

namespace pleinair {

struct CalibrateMarkersOptions {
  std::vector<std::filesystem::path> pictures;
  std::filesystem::path camera;  // A sequence.json with the lens, or its folder.
  std::string dictionary = "apriltag_36h11";
  double size_m = 0.0;           // Of the black border's side.
  std::optional<int> reference;  // Id of the marker that is the world's origin; none: most seen.
  std::filesystem::path anchor;  // A board file that says where some of the markers stand.
  std::filesystem::path out;
};
// Writes the board file, completely or not at all, and returns the report to print. Throws
// std::runtime_error or std::invalid_argument, one line.
std::string RunCalibrateMarkers(const CalibrateMarkersOptions& options);

struct CalibratePoseOptions {
  std::filesystem::path sequence;
  std::filesystem::path markers;  // A board file.
  FrameKind frames = FrameKind::kLinear;
  std::filesystem::path out;  // Empty: nothing is written.
};
// The table to print. Writes a copy of sequence.json in which each frame has the pose of its
// markers; frames without a pose of their own are left out of it, and named. Throws as above, and
// where no frame has one.
std::string RunCalibratePose(const CalibratePoseOptions& options);

}  // namespace pleinair

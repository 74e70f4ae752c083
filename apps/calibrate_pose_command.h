// `pleinair calibrate pose`: where the camera stood, from picked points or the mesh's edges, or in
// each frame of a sequence from the markers in it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "datasets/frame_source.h"

namespace pleinair {

// Exactly one of `markers`, `points` and `edges`.
struct CalibratePoseOptions {
  // A sequence's or site's folder, or for `points` any JSON file with a `camera`.
  std::filesystem::path site;

  std::filesystem::path markers;  // A board file.
  FrameKind frames = FrameKind::kLinear;

  std::filesystem::path points;     // CSV: x, y (pixels), x, y, z (world metres).
  std::optional<double> inlier_px;  // How far off a pick may be; none: PickedPointOptions'.
  // The stated pose counts: of two that fit picks, the one nearer to it; with edges, as
  // CorrectPoseByEdges.
  bool near_stated = false;

  // A picture of the camera; with near_stated there may be several. The rough pose is the stated
  // one.
  std::vector<std::filesystem::path> edges;
  std::vector<std::filesystem::path> more_edges;  // Beside `edges`.
  std::filesystem::path mesh;                     // None: the site's.
  std::optional<double> search_px;                // EdgePoseOptions::reach_px.

  std::filesystem::path out;  // Empty: nothing is written.
};
// The report to print: each pick or frame, and how well the pose is known. Writes a copy of the
// site's file with the pose in `camera`. Of a sequence, each frame of the copy has the pose of its
// markers; frames without a pose of their own are left out and named. Throws std::runtime_error or
// std::invalid_argument, one line: also where no pose can be determined, with the reason.
std::string RunCalibratePose(const CalibratePoseOptions& options);

}  // namespace pleinair

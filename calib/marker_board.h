// Markers in the scene: their places, and the camera's pose from those in a picture.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <tl/expected.hpp>

#include "calib/camera_pose.h"
#include "calib/lens.h"
#include "calib/marker_detection.h"

namespace pleinair {

// One marker of a board; world frame, metres.
struct BoardMarker {
  int id = 0;
  // Corners of the black border, in DetectedMarker's order.
  std::array<glm::dvec3, 4> corners_world_m{};
};

// All markers of a scene.
struct MarkerBoard {
  std::string dictionary;  // As MarkerDictionary::name.
  std::vector<BoardMarker> markers;
};

// {"format": "pleinair-markers", "version": 1, "dictionary": "apriltag_36h11",
//  "markers": [{"id": 0, "corners_world_m": [[x, y, z] x 4]}]}
// Throws JsonError naming file, key and what was expected. It refuses an id that the dictionary
// does not have or that is given twice, and corners that are not those of a square, in order, to 5
// %.
MarkerBoard ReadMarkerBoard(const std::filesystem::path& file);
std::string MarkerBoardText(const MarkerBoard& board);

// The corners of a square with sides of `size_m` about its centre. x is along the marker's top edge
// to the right, y from its bottom to its top, z out of it.
std::array<glm::dvec3, 4> MarkerSquare(double size_m);

// Visible corners and their world points, four for each marker of the board.
std::vector<PointMatch> MatchMarkers(const MarkerBoard& board,
                                     std::span<const DetectedMarker> seen);

// The camera's pose, and the markers that it is from.
struct BoardPose {
  CameraPose pose;
  std::vector<int> markers;   // Ids of inliers: three of their corners are.
  std::vector<int> left_out;  // Ids of the board that were seen but do not fit the others.
};

// Returns the pose from all markers of the board in the picture. Reasons as FindCameraPose's, or
// that no marker was seen; `expected_camera_from_world` as there.
// Throws  std::invalid_argument as FindCameraPose and DetectMarkers.
tl::expected<BoardPose, UndeterminedPose> FindBoardPose(
    const Lens& lens,
    const MarkerBoard& board,
    std::span<const DetectedMarker> seen,
    const CameraPoseOptions& options = {},
    const std::optional<glm::dmat4>& expected_camera_from_world = std::nullopt);

}  // namespace pleinair

// Markers that stand in the scene: where they are, and the camera's pose from those seen in a
// picture.
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

struct BoardMarker {
  int id = 0;
  // Corners of the black border, in DetectedMarker's order.
  std::array<glm::dvec3, 4> corners_world_m{};
};

struct MarkerBoard {
  std::string dictionary;  // As MarkerDictionary::name.
  std::vector<BoardMarker> markers;
};

// {"format": "pleinair-markers", "version": 1, "dictionary": "apriltag_36h11",
//  "markers": [{"id": 0, "corners_world_m": [[x, y, z] x 4]}]}
// Throws  JsonError naming file, key and what was expected: also for an id that the dictionary has
//         not or that comes twice, and for corners that are not those of a square, one after the
//         other, to 5 %.
MarkerBoard ReadMarkerBoard(const std::filesystem::path& file);
std::string MarkerBoardText(const MarkerBoard& board);

// The square of `size_m` a side about its centre, as a marker lies on a table: x along its top edge
// to the right, y from its bottom to its top, z out of it.
std::array<glm::dvec3, 4> MarkerSquare(double size_m);

// Corners seen and where they are, four for each marker that the board has.
std::vector<PointMatch> MatchMarkers(const MarkerBoard& board,
                                     std::span<const DetectedMarker> seen);

struct BoardPose {
  CameraPose pose;
  std::vector<int> markers;   // Ids that count: three of their corners do.
  std::vector<int> left_out;  // Ids of the board, seen where they do not fit the others.
};

// The pose from all markers of the board that are in the picture. Reasons as FindCameraPose's, or
// that none was seen; `expected_camera_from_world` as there.
// Throws  std::invalid_argument as FindCameraPose and DetectMarkers.
tl::expected<BoardPose, UndeterminedPose> FindBoardPose(
    const Lens& lens,
    const MarkerBoard& board,
    std::span<const DetectedMarker> seen,
    const CameraPoseOptions& options = {},
    const std::optional<glm::dmat4>& expected_camera_from_world = std::nullopt);

}  // namespace pleinair

#include "calib/marker_board.h"

#include <algorithm>
#include <set>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "calib/json_cursor.h"

namespace pleinair {
namespace {

using Json = nlohmann::ordered_json;

// Paper stretches, rulers slip; corners in the wrong order differ by 40 % and more.
constexpr double kSquareTolerance = 0.05;

void CheckSquare(const JsonCursor& at, const std::array<glm::dvec3, 4>& corners) {
  const double diagonal = glm::distance(corners[0], corners[2]);
  const auto near = [](double value, double expected) {
    return value > 0.0 && std::abs(value - expected) <= kSquareTolerance * expected;
  };
  bool square = near(glm::distance(corners[1], corners[3]), diagonal);
  for (std::size_t i = 0; i < 4; ++i) {
    square &= near(glm::distance(corners[i], corners[(i + 1) % 4]), std::sqrt(0.5) * diagonal);
  }
  if (!square) {
    at.Fail(
        "the corners of a square: top left, top right, bottom right, bottom left of the marker");
  }
}

}  // namespace

MarkerBoard ReadMarkerBoard(const std::filesystem::path& file) {
  constexpr double kFarthestM = 1e6;
  const nlohmann::json document = LoadJson(file);
  const JsonCursor root(document, file.string());
  root.Required("format").OneOf({"pleinair-markers"});
  root.Required("version").IntegerIn(1, 1);
  root.CheckKeys({"format", "version", "dictionary", "markers"});
  const JsonCursor name = root.Required("dictionary");
  const auto dictionary = FindMarkerDictionary(name.Text());
  if (!dictionary) {
    std::string names;
    for (const std::string& one : MarkerDictionaryNames()) names += " " + one;
    name.Fail("one of" + names);
  }
  MarkerBoard board{dictionary->name, {}};
  std::set<int> ids;
  for (const JsonCursor& at :
       root.Required("markers").List(1, static_cast<std::size_t>(dictionary->marker_count))) {
    at.CheckKeys({"id", "corners_world_m"});
    BoardMarker marker;
    const JsonCursor id = at.Required("id");
    marker.id = id.IntegerIn(0, dictionary->marker_count - 1);
    if (!ids.insert(marker.id).second) id.Fail("each id once");
    const JsonCursor corners = at.Required("corners_world_m");
    const auto entries = corners.List(4, 4);
    for (std::size_t c = 0; c < 4; ++c) {
      const auto coordinates = entries[c].List(3, 3);
      for (int axis = 0; axis < 3; ++axis) {
        marker.corners_world_m[c][axis] =
            coordinates[static_cast<std::size_t>(axis)].NumberIn(-kFarthestM, kFarthestM);
      }
    }
    CheckSquare(corners, marker.corners_world_m);
    board.markers.push_back(marker);
  }
  return board;
}

std::string MarkerBoardText(const MarkerBoard& board) {
  Json json = {{"format", "pleinair-markers"},
               {"version", 1},
               {"dictionary", board.dictionary},
               {"markers", Json::array()}};
  for (const BoardMarker& marker : board.markers) {
    Json corners = Json::array();
    for (const glm::dvec3& corner : marker.corners_world_m) {
      corners.push_back({corner.x, corner.y, corner.z});
    }
    json["markers"].push_back({{"id", marker.id}, {"corners_world_m", std::move(corners)}});
  }
  return json.dump(1) + "\n";
}

std::array<glm::dvec3, 4> MarkerSquare(double size_m) {
  const double half = 0.5 * size_m;
  return {{{-half, half, 0.0}, {half, half, 0.0}, {half, -half, 0.0}, {-half, -half, 0.0}}};
}

std::vector<PointMatch> MatchMarkers(const MarkerBoard& board,
                                     std::span<const DetectedMarker> seen) {
  std::vector<PointMatch> matches;
  for (const DetectedMarker& marker : seen) {
    const auto found =
        std::find_if(board.markers.begin(), board.markers.end(), [&](const BoardMarker& candidate) {
          return candidate.id == marker.id;
        });
    if (found == board.markers.end()) continue;
    for (std::size_t c = 0; c < 4; ++c) {
      matches.push_back({found->corners_world_m[c], marker.corners_px[c]});
    }
  }
  return matches;
}

tl::expected<BoardPose, UndeterminedPose> FindBoardPose(
    const Lens& lens,
    const MarkerBoard& board,
    std::span<const DetectedMarker> seen,
    const CameraPoseOptions& options,
    const std::optional<glm::dmat4>& expected_camera_from_world) {
  std::vector<DetectedMarker> known;
  for (const DetectedMarker& marker : seen) {
    if (!MatchMarkers(board, {&marker, 1}).empty()) known.push_back(marker);
  }
  if (known.empty()) {
    return tl::unexpected(UndeterminedPose{
        seen.empty() ? "no marker is seen"
                     : "no marker of the board is seen (but " + std::to_string(seen.size()) +
                           " other" + (seen.size() == 1 ? ")" : "s)"),
        {}});
  }
  auto pose = FindCameraPose(lens, MatchMarkers(board, known), options, expected_camera_from_world);
  if (!pose) return tl::unexpected(std::move(pose.error()));
  BoardPose result;
  for (std::size_t i = 0; i < known.size(); ++i) {
    int fitting = 0;
    for (std::size_t c = 0; c < 4; ++c) fitting += pose->counts[4 * i + c] ? 1 : 0;
    (fitting >= 3 ? result.markers : result.left_out).push_back(known[i].id);
  }
  result.pose = std::move(*pose);
  return result;
}

}  // namespace pleinair

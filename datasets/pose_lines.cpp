#include "datasets/pose_lines.h"

#include <fstream>

#include "calib/json_cursor.h"
#include "datasets/internal/sequence_values.h"

namespace pleinair {

TimedPose ReadPoseLine(std::string_view line, const std::string& label) {
  const nlohmann::json document = ParseJson(line, label);
  const JsonCursor at(document, label);
  at.CheckKeys({"time_utc", "camera_from_world"});
  return {ReadTime(at.Required("time_utc")), ReadRigid(at.Required("camera_from_world"))};
}

PoseTrack ReadPoses(const std::filesystem::path& file, const PoseTrackOptions& options) {
  PoseTrack track(options);
  std::error_code error;
  std::ifstream lines;
  if (!std::filesystem::is_directory(file, error)) lines.open(file, std::ios::binary);
  if (!lines.is_open()) {
    throw JsonError(file.string() + ": expected a file of camera poses, a line of JSON each");
  }
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    track.Add(ReadPoseLine(line, file.string() + ":" + std::to_string(number)));
  }
  if (lines.bad()) throw JsonError(file.string() + ": cannot be read to its end");
  if (track.IsEmpty()) {
    throw JsonError(file.string() + ": expected camera poses, a line of JSON each, found none");
  }
  return track;
}

}  // namespace pleinair

// Camera poses from outside, a line of JSON each:
// {"time_utc": "2026-06-21T10:00:00.033Z", "camera_from_world": [[4x4, row by row]]}
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "calib/pose_track.h"
#include "calib/timed_pose.h"

namespace pleinair {

// Throws  JsonError, one line that begins with `label`: not JSON, an unknown key, an invalid time
//         or pose.
TimedPose ReadPoseLine(std::string_view line, const std::string& label);

// Reads all lines of a file or pipe, up to its end; empty ones are ignored. Throws JsonError, one
// line with file and line number; where there is no pose in it.
PoseTrack ReadPoses(const std::filesystem::path& file, const PoseTrackOptions& options = {});

}  // namespace pleinair

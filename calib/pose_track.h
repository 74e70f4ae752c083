// Poses of a moving camera in the order of their times, and the pose at a frame's time.
#pragma once

#include <cstddef>
#include <deque>
#include <string>

#include <glm/mat4x4.hpp>
#include <tl/expected.hpp>

#include "calib/timed_pose.h"
#include "scene/utc_time.h"

namespace pleinair {

// Set-up of the track; seconds.
struct PoseTrackOptions {
  // Largest gap between two poses between which a frame's pose is interpolated.
  double most_gap_s = 0.2;
  // How long a pose is used for frames after it, or before it, where there is none on their other
  // side; 0 or more.
  double hold_s = 0.2;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// The pose at a time.
struct TrackPose {
  glm::dmat4 camera_from_world{1.0};
  double held_s = 0.0;  // Time from the frame to the pose that is used for it; 0: interpolated.
};

// One thread at a time.
class PoseTrack {
 public:
  // Keeps the `most_poses` latest; 0: all. Throws as PoseTrackOptions::Validate.
  explicit PoseTrack(const PoseTrackOptions& options = {}, std::size_t most_poses = 0);

  // For the poses that are there, too. Throws as PoseTrackOptions::Validate.
  void SetOptions(const PoseTrackOptions& options);
  // Adds a pose, in any order of times; of two poses with one time the later call's holds. Throws
  // std::invalid_argument, one line, for an invalid pose (FaultOfPose).
  void Add(const TimedPose& pose);

  bool IsEmpty() const { return poses_.empty(); }
  // Whether a pose at `time` or later is there: then no further one is needed for At.
  bool Reaches(UtcTime time) const { return !IsEmpty() && poses_.back().time >= time; }
  // Time of the latest pose; throws std::logic_error where there is none.
  UtcTime LatestTime() const;
  // Returns the camera's pose at `time`, or one line with the distance of the nearest pose, which
  // is too far.
  tl::expected<TrackPose, std::string> At(UtcTime time) const;

 private:
  PoseTrackOptions options_;
  std::size_t most_poses_;
  std::deque<TimedPose> poses_;  // By time.
};

}  // namespace pleinair

// Tracks a moving camera's pose over frames of which some have none or a wrong one.
#pragma once

#include <optional>
#include <string>

#include <glm/mat4x4.hpp>
#include <tl/expected.hpp>

#include "scene/utc_time.h"

namespace pleinair {

// Limits of the tracker; frames' own times.
struct PoseTrackerOptions {
  // How long the last pose replaces a missing one: both limits hold; 0 or more.
  int carry_frames = 3;
  double carry_s = 0.2;
  // A faster move from the last pose is not accepted before it is confirmed; above 0.
  double believable_speed_m_s = 5.0;
  double believable_turn_rad_s = 6.0;
  // Additional difference allowed between two poses of a camera at rest; 0 or more.
  double noise_m = 0.1;
  double noise_rad = 0.05;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

enum class PoseOrigin { kFound, kCarried };

// A frame's pose and its origin.
struct TrackedPose {
  glm::dmat4 camera_from_world{1.0};
  PoseOrigin origin = PoseOrigin::kFound;
  int carried_frames = 0;  // Since the pose was found; 0 where it is this frame's own.
};

// For each frame:
// - A pose is found, and there is none to compare with (the first one, or lost): accepted at once.
// - Found, and plausible after the last one: accepted.
// - Found, but not plausible: held, and the frame counts as one without. A next one that is
//   plausible after the held one confirms it, and is accepted; one that is plausible after the last
//   pose shows that the held one was wrong.
// - Not found: the last pose is carried, for carry_frames frames and carry_s seconds (of the
//   frames' own times, whichever way they go) at most. After that the camera is lost: the frame has
//   no pose, and the next found pose is accepted at once.
class PoseTracker {
 public:
  // Throws as PoseTrackerOptions::Validate.
  explicit PoseTracker(const PoseTrackerOptions& options = {});

  // The last pose, where it is recent enough to be carried to `time`: FindCameraPose may use it to
  // choose between two poses.
  std::optional<glm::dmat4> Expected(UtcTime time) const;

  // Returns the frame's pose, or one line that begins with "camera pose is not known: " and ends
  // with `reason` or the tracker's own. `found_camera_from_world` is none where the frame has none,
  // because of `reason`.
  tl::expected<TrackedPose, std::string> Update(
      UtcTime time,
      const std::optional<glm::dmat4>& found_camera_from_world,
      const std::string& reason = {});

 private:
  struct Known {
    UtcTime time{};
    glm::dmat4 camera_from_world{1.0};
  };
  bool IsBelievable(const Known& from, UtcTime time, const glm::dmat4& to) const;
  bool IsRecent(const Known& known, UtcTime time) const;

  PoseTrackerOptions options_;
  std::optional<Known> last_;
  std::optional<Known> aside_;
  int missed_ = 0;  // Frames since last_.
};

}  // namespace pleinair

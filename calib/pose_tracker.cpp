#include "calib/pose_tracker.h"

#include <chrono>
#include <cmath>

#include <glm/geometric.hpp>

#include "calib/camera_pose.h"
#include "calib/internal/camera_centre.h"
#include "calib/internal/check_number.h"

namespace pleinair {
namespace {

double SecondsBetween(UtcTime a, UtcTime b) {
  return std::abs(std::chrono::duration<double>(b - a).count());
}

}  // namespace

void PoseTrackerOptions::Validate() const {
  RequireOption(carry_frames >= 0, "carry_frames", carry_frames, "0 or more");
  RequireOption(carry_s >= 0.0, "carry_s", carry_s, "0 or more");
  RequireOption(
      believable_speed_m_s > 0.0, "believable_speed_m_s", believable_speed_m_s, "above 0");
  RequireOption(
      believable_turn_rad_s > 0.0, "believable_turn_rad_s", believable_turn_rad_s, "above 0");
  RequireOption(noise_m >= 0.0, "noise_m", noise_m, "0 or more");
  RequireOption(noise_rad >= 0.0, "noise_rad", noise_rad, "0 or more");
}

PoseTracker::PoseTracker(const PoseTrackerOptions& options) : options_(options) {
  options.Validate();
}

bool PoseTracker::IsBelievable(const Known& from, UtcTime time, const glm::dmat4& to) const {
  const double elapsed_s = SecondsBetween(from.time, time);
  return glm::distance(CentreOfCamera(from.camera_from_world), CentreOfCamera(to)) <=
             options_.noise_m + options_.believable_speed_m_s * elapsed_s &&
         RotationBetweenRad(from.camera_from_world, to) <=
             options_.noise_rad + options_.believable_turn_rad_s * elapsed_s;
}

bool PoseTracker::IsRecent(const Known& known, UtcTime time) const {
  return missed_ < options_.carry_frames && SecondsBetween(known.time, time) <= options_.carry_s;
}

std::optional<glm::dmat4> PoseTracker::Expected(UtcTime time) const {
  if (!last_ || !IsRecent(*last_, time)) return std::nullopt;
  return last_->camera_from_world;
}

tl::expected<TrackedPose, std::string> PoseTracker::Update(
    UtcTime time,
    const std::optional<glm::dmat4>& found_camera_from_world,
    const std::string& reason) {
  const bool can_carry = last_ && IsRecent(*last_, time);
  std::string why = reason;
  if (found_camera_from_world) {
    const glm::dmat4& found = *found_camera_from_world;
    if (!can_carry || IsBelievable(*last_, time, found) ||
        (aside_ && IsBelievable(*aside_, time, found))) {
      last_ = Known{time, found};
      aside_.reset();
      missed_ = 0;
      return TrackedPose{found, PoseOrigin::kFound, 0};
    }
    aside_ = Known{time, found};
    why = "it jumped, and no next frame has confirmed that";
  }
  if (!can_carry) {
    last_.reset();
    aside_.reset();
    missed_ = 0;
    return tl::unexpected("camera pose is not known: " + why);
  }
  ++missed_;
  return TrackedPose{last_->camera_from_world, PoseOrigin::kCarried, missed_};
}

}  // namespace pleinair

#include "calib/pose_track.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calib/internal/check_number.h"
#include "calib/internal/residual_text.h"

namespace pleinair {
namespace {

std::string SecondsText(double seconds) { return NumberText("%.3f s", seconds); }

bool IsBefore(const TimedPose& pose, UtcTime time) { return pose.time < time; }

}  // namespace

void PoseTrackOptions::Validate() const {
  RequireOption(most_gap_s >= 0.0, "most_gap_s", most_gap_s, "0 or more seconds");
  RequireOption(hold_s >= 0.0, "hold_s", hold_s, "0 or more seconds");
}

PoseTrack::PoseTrack(const PoseTrackOptions& options, std::size_t most_poses)
    : options_(options), most_poses_(most_poses) {
  options.Validate();
}

void PoseTrack::SetOptions(const PoseTrackOptions& options) {
  options.Validate();
  options_ = options;
}

void PoseTrack::Add(const TimedPose& pose) {
  if (const std::string fault = FaultOfPose(pose.camera_from_world); !fault.empty()) {
    throw std::invalid_argument("camera_from_world: expected " + fault);
  }
  const auto at = std::lower_bound(poses_.begin(), poses_.end(), pose.time, IsBefore);
  if (at != poses_.end() && at->time == pose.time) {
    *at = pose;
    return;
  }
  poses_.insert(at, pose);
  if (most_poses_ > 0 && poses_.size() > most_poses_) poses_.pop_front();
}

UtcTime PoseTrack::LatestTime() const {
  if (IsEmpty()) throw std::logic_error("PoseTrack::LatestTime: there is no pose");
  return poses_.back().time;
}

tl::expected<TrackPose, std::string> PoseTrack::At(UtcTime time) const {
  if (IsEmpty()) return tl::unexpected(std::string("there is no pose yet"));
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), time, IsBefore);
  if (after != poses_.end() && after->time == time) return TrackPose{after->camera_from_world, 0.0};
  if (after == poses_.begin() || after == poses_.end()) {
    const bool is_late = after == poses_.end();
    const TimedPose& nearest = is_late ? poses_.back() : poses_.front();
    const double away_s = std::abs(SecondsFromTo(nearest.time, time));
    if (away_s <= options_.hold_s) return TrackPose{nearest.camera_from_world, away_s};
    return tl::unexpected((is_late ? "the last pose is " : "the first pose is ") +
                          SecondsText(away_s) + (is_late ? " older" : " later") +
                          " than the frame, expected at most " + SecondsText(options_.hold_s));
  }
  const TimedPose& before = *std::prev(after);
  const double gap_s = SecondsFromTo(before.time, after->time);
  if (gap_s <= options_.most_gap_s) return TrackPose{PoseBetween(before, *after, time), 0.0};
  // Between two, neither of which says what the camera did meanwhile.
  const double since_s = SecondsFromTo(before.time, time);
  const double until_s = SecondsFromTo(time, after->time);
  const bool is_after_nearer = until_s < since_s;
  if (std::min(since_s, until_s) <= options_.hold_s) {
    return TrackPose{(is_after_nearer ? *after : before).camera_from_world,
                     std::min(since_s, until_s)};
  }
  return tl::unexpected("there is no pose for " + SecondsText(gap_s) +
                        " around the frame, expected at most " + SecondsText(options_.most_gap_s));
}

}  // namespace pleinair

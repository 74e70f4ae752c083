// Averages the poses of a camera at rest, and does not change those of a moving one.
#pragma once

#include <deque>

#include <glm/mat4x4.hpp>

#include "calib/timed_pose.h"
#include "scene/camera.h"

namespace pleinair {

// Set-up of the filter.
struct PoseFilterOptions {
  // Poses are compared by the shift in the picture of things at half and at twice this distance.
  double distance_m = 5.0;
  // Longest time to average over: long enough to lower the noise of 10 poses a second to a fifth.
  double window_s = 3.0;
  // Least number of poses for a camera at rest: half a second at 30 a second. With fewer, a slow
  // motion would be noticed only after it has left the mean by more than a pixel.
  int least_poses = 16;
  // Poses that scatter more are motion, not noise: the tremor of a hand is followed.
  double most_noise_px = 1.0;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// The state of PoseFilter.
struct PoseFilterState {
  std::deque<TimedPose> recent;  // As received, oldest first.
  glm::dmat4 last_result{1.0};   // The filtered pose for the newest one.
  // For reports: the number of poses of the last mean (1: the pose itself), and the measured noise,
  // rms; 0: not yet.
  int averaged = 0;
  double noise_px = 0.0;
};

// The result is the mean of the longest run of latest poses, at least least_poses, that are
// consistent with a camera at rest. Where there is none, it is the newest pose, unchanged.
//
// Test     A run is at rest if no 1, 2, 4, 8 ... of its last or first poses have a mean that is
//          farther from the mean of the others than their noise explains, at a level of 1e-4 each.
//          This is adaptive windowing (Bifet and Gavalda, SIAM Data Mining 2007; there the bound is
//          Hoeffding's, here the noise is known). Distances are rms pixels over points in view. A
//          sum of correlated squares is treated as a chi-square of fitted degrees (Satterthwaite,
//          Biometrics 2(6), 1946).
// Noise    From second differences of the poses, in which steady motion cancels; the largest are
//          left out.
// Accuracy For poses with 0.5 px of noise, 30 a second: 0.06 px rms at rest. For a camera that
// creeps by less than 0.1 px a pose the result is up to 0.4 px behind. For a faster one it is not
// behind once the motion is noticed, and by less than 1 px (two deviations of the noise) before.
// Gaps     Poses older than window_s are dropped. A pose that is not later than the one before
//          restarts the filter. One that equals the one before is no new measurement: the last
//          result holds.
// Cost     10 us at 30 poses a second.
// Threads  The class has no state of its own.
class PoseFilter {
 public:
  // Throws as PoseFilterOptions::Validate.
  explicit PoseFilter(const PoseFilterOptions& options = {});

  // Returns the filtered pose. Throws std::invalid_argument for an invalid pose (FaultOfPose).
  glm::dmat4 Update(const CameraIntrinsics& camera,
                    const TimedPose& pose,
                    PoseFilterState& state) const;

 private:
  PoseFilterOptions options_;
};

}  // namespace pleinair

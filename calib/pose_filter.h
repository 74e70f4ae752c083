// Steadies the poses of a camera at rest, and leaves those of a moving one as they are.
#pragma once

#include <deque>

#include <glm/mat4x4.hpp>

#include "calib/timed_pose.h"
#include "scene/camera.h"

namespace pleinair {

struct PoseFilterOptions {
  // Poses are compared by how far apart they show things at half and at twice this distance.
  double distance_m = 5.0;
  // What is averaged over at most: long enough to lower the noise of 10 poses a second to a fifth.
  double window_s = 3.0;
  // A camera is not taken to be at rest from fewer: half a second at 30 a second. With fewer, a
  // slow motion is noticed only after it has left the mean by more than a pixel.
  int least_poses = 16;
  // Poses that scatter more are motion, not noise: a hand's tremor is to be followed.
  double most_noise_px = 1.0;

  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// What PoseFilter keeps from pose to pose.
struct PoseFilterState {
  std::deque<TimedPose> recent;  // As they came, oldest first.
  glm::dmat4 last_result{1.0};   // Of the newest of them.
  // For reports: how many poses the last result is the mean of (1: it is the pose itself), and the
  // noise that was measured, rms; 0: not yet.
  int averaged = 0;
  double noise_px = 0.0;
};

// The result is the mean of the longest run of last poses that a camera at rest can have given, of
// least_poses or more; where there is none it is the newest pose, unchanged.
//
// Test     A run is at rest if no 1, 2, 4, 8 ... of its last or first poses have a mean that is
//          farther from the mean of the others than their noise explains, at a level of 1e-4 each
//          (adaptive windowing: Bifet and Gavalda, SIAM Data Mining 2007; there the bound is
//          Hoeffding's, here the noise is known). Distances are rms pixels over points in view; a
//          sum of correlated squares is taken as a chi-square of fitted degrees (Satterthwaite,
//          Biometrics 2(6), 1946).
// Noise    From second differences of the poses, which steady motion cancels out of; their largest
//          are left out.
// Accuracy Poses with 0.5 px of noise, 30 a second: 0.06 px rms at rest. A camera that
//          creeps by less than 0.1 px a pose is up to 0.4 px behind; a faster one is not behind
//          once it is noticed to move, and by less than 1 px (two deviations of the noise) before.
// Gaps     Poses older than window_s count no more. A pose that is not later than the one before
//          begins again. One that equals the one before is no new measurement: the last result
//          holds.
// Cost     10 us at 30 poses a second.
// Threads  The class has no state of its own.
class PoseFilter {
 public:
  // Throws as PoseFilterOptions::Validate.
  explicit PoseFilter(const PoseFilterOptions& options = {});

  // Throws std::invalid_argument where the pose is none (FaultOfPose).
  glm::dmat4 Update(const CameraIntrinsics& camera,
                    const TimedPose& pose,
                    PoseFilterState& state) const;

 private:
  PoseFilterOptions options_;
};

}  // namespace pleinair

// Poses as trackers give them: of a known camera, with noise.
#pragma once

#include <chrono>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include "calib/timed_pose.h"
#include "scene/camera.h"
#include "tests/calib/marker_scene.h"

namespace pleinair {

inline CameraIntrinsics TrackedCamera() {
  CameraIntrinsics camera = MarkerCamera();
  camera.fx_px = camera.fy_px = 600.0;
  camera.distortion = {};
  return camera;
}

inline UtcTime FrameTime(int frame, double frames_per_second = 30.0) {
  const auto offset = std::chrono::duration<double>(frame / frames_per_second);
  return UtcTime(std::chrono::sys_days{std::chrono::year{2026} / 6 / 21}) +
         std::chrono::duration_cast<std::chrono::nanoseconds>(offset);
}

inline constexpr double kObjectM = 5.0;

// What an object kObjectM before the camera of `truth` is drawn beside its place at pose `shown`.
inline glm::dvec2 WobblePx(const glm::dmat4& truth, const glm::dmat4& shown) {
  const glm::dvec4 object_world = glm::inverse(truth) * glm::dvec4(0.0, 0.0, kObjectM, 1.0);
  const glm::dvec3 seen(shown * object_world);
  return TrackedCamera().fx_px * glm::dvec2(seen) / seen.z;
}

// So that WobblePx of the poses is `rms_px`: half of its variance from the place, half from the
// rotation.
class NoisyPoses {
 public:
  NoisyPoses(double rms_px, unsigned seed) : rms_px_(rms_px), random_(seed) {}
  glm::dmat4 Of(const glm::dmat4& truth) {
    // Both count in x and y.
    const double each_rad = 0.5 * rms_px_ / TrackedCamera().fx_px;
    const double each_m = each_rad * kObjectM;
    const auto draw = [&] {
      return glm::dvec3(normal_(random_), normal_(random_), normal_(random_));
    };
    const glm::dvec3 moved = each_m * draw();
    return Changed(truth, {moved, each_rad * draw()});
  }

 private:
  double rms_px_;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace pleinair

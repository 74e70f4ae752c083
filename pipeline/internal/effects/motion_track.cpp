#include "pipeline/internal/effects/motion_track.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace pleinair {
namespace {

glm::dvec3 MiddleOf(const BoundingBox& box) {
  return 0.5 * (glm::dvec3(box.lower_m) + glm::dvec3(box.upper_m));
}

// Largest shift of the corners when `after` moves them; corners that are not before the camera both
// times have 0. Without the lens' distortion.
double ShiftPx(const BoundingBox& box,
               const Camera& camera,
               const glm::dmat4& camera_from_world_after,
               const glm::dmat4& after) {
  const CameraIntrinsics& lens = camera.intrinsics;
  double largest = 0.0;
  for (const glm::vec3& corner : CornersOf(box)) {
    const glm::dvec4 here(corner, 1.0);
    const glm::dvec4 now = camera.camera_from_world * here;
    const glm::dvec4 then = camera_from_world_after * after * here;
    if (!(now.z > 0.0 && then.z > 0.0)) continue;
    largest = std::max(largest,
                       std::hypot(lens.fx_px * (then.x / then.z - now.x / now.z),
                                  lens.fy_px * (then.y / then.z - now.y / now.z)));
  }
  return largest;
}

}  // namespace

MotionTrack::Found MotionTrack::At(const Instant& now) {
  const bool is_same_frame = last_ && last_->time == now.time &&
                             last_->world_from_given.size() == now.world_from_given.size();
  if (!is_same_frame) {
    Take(now);
  } else {
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (last_->world_from_given[i] != now.world_from_given[i]) objects_[i] = {};
    }
    if (last_->camera != now.camera) camera_ = {};
  }
  last_ = now;
  Found found{camera_.motion, {}, why_still_, known_s_};
  for (const Thing& object : objects_) found.objects.push_back(object.motion);
  return found;
}

void MotionTrack::Take(const Instant& now) {
  const std::size_t count = now.world_from_given.size();
  const std::vector<Thing> before = objects_.size() == count ? objects_ : std::vector<Thing>(count);
  objects_.assign(count, {});
  const Thing camera_before = camera_;
  camera_ = {};
  known_s_ = 0.0;
  why_still_ = "no pose of a frame before";
  if (!last_ || last_->world_from_given.size() != count) return;
  if (last_->camera.intrinsics != now.camera.intrinsics) return;
  const double seconds = std::chrono::duration<double>(now.time - last_->time).count();
  why_still_ = "frames too far apart, or not in order";
  if (!(seconds > 0.0 && seconds <= kLongestGapS)) return;
  known_s_ = seconds;
  why_still_ = "nothing moves";
  double camera_shift_px = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dmat4 undone = last_->world_from_given[i] * glm::inverse(now.world_from_given[i]);
    const BoundingBox& box = now.boxes[i];
    camera_shift_px =
        std::max(camera_shift_px,
                 ShiftPx(box, now.camera, last_->camera.camera_from_world, glm::dmat4(1.0)));
    if (last_->world_from_given[i] == now.world_from_given[i]) continue;
    objects_[i] = Judged(glm::inverse(undone),
                         MiddleOf(box),
                         ShiftPx(box, now.camera, now.camera.camera_from_world, undone),
                         seconds,
                         before[i].px_per_s);
  }
  if (last_->camera.camera_from_world == now.camera.camera_from_world) return;
  camera_ = Judged(glm::inverse(now.camera.camera_from_world) * last_->camera.camera_from_world,
                   now.camera.CentreWorldM(),
                   camera_shift_px,
                   seconds,
                   camera_before.px_per_s);
}

MotionTrack::Thing MotionTrack::Judged(const glm::dmat4& now_from_before,
                                       const glm::dvec3& centre_m,
                                       double shift_px,
                                       double seconds,
                                       double px_per_s_before) const {
  Thing thing;
  thing.px_per_s = shift_px / seconds;
  const double likely_px = kStartPx + 4.0 * px_per_s_before * seconds;
  const double most_px = 0.25 * last_->camera.intrinsics.width_px;
  if (!(shift_px <= std::min(likely_px, most_px))) return thing;
  if (auto motion = MotionOf(now_from_before, seconds, centre_m)) thing.motion = *motion;
  return thing;
}

double LargestShiftPx(const ExposureMotion& motion,
                      const Camera& camera,
                      const std::vector<BoundingBox>& boxes,
                      double seconds) {
  double largest = 0.0;
  for (const double time : {-seconds, seconds}) {
    const glm::dmat4 camera_from_world =
        camera.camera_from_world * glm::inverse(motion.camera.After(time));
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      largest = std::max(
          largest, ShiftPx(boxes[i], camera, camera_from_world, motion.objects[i].After(time)));
    }
  }
  return largest;
}

}  // namespace pleinair

// The motion of camera and objects during the exposure, from the poses of frames.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "scene/camera.h"
#include "scene/exposure_motion.h"
#include "scene/mesh.h"
#include "scene/utc_time.h"

namespace pleinair {

// The motion from the last frame to this one is assumed to continue. There is none between frames
// that are farther apart than kLongestGapS or not in order, and none over a cut. A cut is a shift
// of more than a quarter of the picture's width, or of more than kStartPx and four times the shift
// before. So a fast motion counts from its second frame on.
class MotionTrack {
 public:
  static constexpr double kLongestGapS = 0.5;
  static constexpr double kStartPx = 8.0;

  struct Instant {
    UtcTime time{};
    Camera camera;
    std::vector<glm::dmat4> world_from_given;  // For each object; see PosedObjects.
    std::vector<BoundingBox> boxes;            // In the world, around each object.
  };
  struct Found {
    SteadyMotion camera;
    std::vector<SteadyMotion> objects;
    std::string_view why_still;  // The reason where nothing moves.
    double known_s = 0.0;        // The time since the last frame; 0: unknown.
  };

  // Returns the motion at the next frame. The same time again is the same frame: objects that have
  // been moved within it stand still.
  Found At(const Instant& now);

 private:
  struct Thing {
    SteadyMotion motion;
    double px_per_s = 0.0;  // In the picture, at most.
  };

  void Take(const Instant& now);
  Thing Judged(const glm::dmat4& now_from_before,
               const glm::dvec3& centre_m,
               double shift_px,
               double seconds,
               double px_per_s_before) const;

  std::optional<Instant> last_;
  Thing camera_;
  std::vector<Thing> objects_;
  double known_s_ = 0.0;
  std::string_view why_still_;
};

// The largest shift of the boxes' corners in the picture between the frame's instant and `seconds`
// before or after it.
double LargestShiftPx(const ExposureMotion& motion,
                      const Camera& camera,
                      const std::vector<BoundingBox>& boxes,
                      double seconds);

}  // namespace pleinair

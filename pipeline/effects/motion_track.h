// What the poses of frames say of how things move while they are exposed.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include <glm/mat4x4.hpp>

#include "scene/camera.h"
#include "scene/exposure_motion.h"
#include "scene/mesh.h"
#include "scene/utc_time.h"

namespace pleinair {

struct MotionBlurOptions {
  double exposure_s = 0.0;  // Of frames that do not state it. 0: they are not blurred by motion.
  double readout_s = 0.0;   // From the first row's exposure to the last one's; 0: all at once.
  // Throws std::invalid_argument naming the field and its value.
  void Validate() const;
};

// Motion is that from the last frame to this one, as if it went on. Not from frames that are
// farther apart than kLongestGapS or not in order, and not over a cut: from one frame to the next a
// thing moves by no more than a quarter of the picture, and by no more than four times what it did
// before, and kStartPx. So a fast motion counts from its second frame on.
class MotionTrack {
 public:
  static constexpr double kLongestGapS = 0.5;
  static constexpr double kStartPx = 8.0;

  struct Instant {
    UtcTime time{};
    Camera camera;
    std::vector<glm::dmat4> world_from_given;  // Of each object; see PosedObjects.
    std::vector<BoundingBox> boxes;            // Of the objects in the world, as they stand there.
  };
  struct Found {
    SteadyMotion camera;
    std::vector<SteadyMotion> objects;
    std::string_view why_still;  // Where nothing moves.
  };

  // The frames one after the other. The same time again is the same frame: objects that have been
  // moved within it stand still.
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
  std::string_view why_still_;
};

// The largest way of the boxes' corners in the picture from where they are at the frame's instant
// to where they are so much later.
double LargestShiftPx(const ExposureMotion& motion,
                      const Camera& camera,
                      const std::vector<BoundingBox>& boxes,
                      double seconds);

}  // namespace pleinair

// Warns of a sun whose direction the pictures' shadows contradict.
#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include <glm/vec3.hpp>

#include "pipeline/shadow_direction.h"
#include "scene/frame.h"
#include "scene/lighting.h"
#include "scene/mesh.h"

namespace pleinair {

// A sun whose stated direction the shadows of one frame contradict. Directions are unit, in the
// model's frame.
struct SunContradiction {
  int frame = 0;
  glm::dvec3 stated_enu{0.0, 0.0, 1.0};
  glm::dvec3 shown_enu{0.0, 0.0, 1.0};
  double angle_rad = 0.0;
  double stddev_rad = 0.0;  // Of that angle.
};

// What a look that was not stopped has found.
struct SunLook {
  std::optional<SunContradiction> contradiction;
};

// Checks a few frames of a run, at most kMostLooks: the 1st, 2nd, 4th, 8th ... It also checks those
// whose sun has moved by 10 deg, or whose sun's share of the light has changed by a third, since
// the last check.
class SunCheck {
 public:
  static constexpr int kMostLooks = 12;

  // Throws as ShadowDirectionFinder.
  SunCheck(Mesh mesh, std::span<const std::string> diffuse_regions);

  // Whether to Look at this frame; each call counts one frame.
  bool IsDue(const Lighting& lighting);
  // `lighting` is the frame's light, with the sun in its stated or computed direction. Returns a
  // contradiction once, and again only where the shadows show the sun 5 deg or more from the last
  // time. Costs as ShadowDirectionFinder::ShownBy.
  std::optional<SunContradiction> Look(const Frame& frame, const Lighting& lighting);
  // The same; none where it was stopped before it had ended, and then as though never called.
  std::optional<SunLook> Look(const Frame& frame,
                              const Lighting& lighting,
                              const std::stop_token& stop);

 private:
  struct Looked {
    glm::dvec3 sun_enu{0.0};
    double sun_share = 0.0;
  };
  ShadowDirectionFinder finder_;
  int calls_ = 0;
  int looks_ = 0;
  std::optional<Looked> last_look_;
  // Turn about the vertical by all looks near the stated sun, as weighted sums.
  double information_ = 0.0;
  double weighted_offset_rad_ = 0.0;
  double weighted_square_ = 0.0;
  int turns_ = 0;
  std::optional<double> warned_of_rad_;  // Angle.
};

}  // namespace pleinair

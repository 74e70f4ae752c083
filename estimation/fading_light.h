// The light between the end of a filter's run and the mean of the next one.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/seen_steps.h"
#include "scene/lighting.h"

namespace pleinair {

// Horizontal irradiance by one unit of the sun.
double SunToHorizontal(const Lighting& lighting);
// Scales each channel to the horizontal irradiance that `raw` has.
void GiveTotalOf(const Lighting& raw, Lighting& lighting);
// The unit of light in a filter, by channel: the horizontal irradiance of light that is relative
// per frame.
glm::dvec3 UnitOf(const Lighting& lighting, LightUnits units);

// A step that agrees with what is seen of it to this relative error is followed completely.
inline constexpr double kSeenAgreement = 0.25;

// Whether a run of the sun, or of the sky, has ended with a frame, and what surfaces in common show
// of the change from its mean to that of the next one.
struct RunEnding {
  bool has_ended = false;
  std::optional<SeenStep> seen;
};

// Keeps what a filter reported last. Where a run ends for a change that is not seen, or is small,
// the old light fades.
class FadingLight {
 public:
  // Adds to `lighting`, the mean of the present run, what is left of the light before, and its
  // square to the covariance. `raw` is the frame's own light. Called for each frame, in order.
  void Add(LightUnits units,
           const std::array<RunEnding, 2>& endings,
           Lighting& lighting,
           const Lighting& raw);

 private:
  // In the order of Lighting::covariance, in the filter's units.
  std::vector<double> reported_;  // Last, at reported_time_.
  UtcTime reported_time_{};
  std::vector<double> fading_;                // The part of it that still fades.
  std::array<double, 2> fading_s_{1.0, 1.0};  // With this time constant, of sun and sky.
};

}  // namespace pleinair

// Changes of light between frames in the units of a filter.
#pragma once

#include <array>
#include <optional>

#include <glm/vec3.hpp>

#include "estimation/light_change.h"
#include "scene/lighting.h"

namespace pleinair {

// The change of the sun or of the entire sky.
struct SeenStep {
  glm::dvec3 value{0.0};
  glm::dvec3 variance{0.0};
  // Sun and sky have changed by one factor in all channels, as by a wrong exposure, or not at all.
  bool may_be_exposure = true;
};
using SeenSteps = std::array<SeenStep, 2>;  // Sun, sky.

// Of lights that are relative per frame the change of their shares in the horizontal irradiance, to
// which a unit of the sun adds `sun_to_horizontal`. None where there is no change to read, or no
// light.
std::optional<SeenSteps> SeenStepsOf(const std::optional<LightChange>& change,
                                     LightUnits units,
                                     double sun_to_horizontal);

// Of one change after the other; none where either is unknown. As uncertain as the less certain
// one: most surfaces stay, so that the noise of the frame between enters both with opposite signs.
std::optional<SeenSteps> SumOf(const std::optional<SeenSteps>& first,
                               const std::optional<SeenSteps>& second);

}  // namespace pleinair

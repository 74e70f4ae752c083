// How visible a change of the light at a single probe can be.
#pragma once

#include <algorithm>
#include <numbers>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "objects/single_probe_light.h"
#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"

namespace pleinair {

// Above this share of a vertex's view, what objects hide from themselves is visible under any sky.
inline constexpr float kMostHidden = 0.02f;

// Returns the largest change, in code values, of a surface with one of the compared facings, whose
// light changes by `change_of` at most, and by the share `hidden` that objects hide.
template <class ChangeOf>
float ChangeOfFacings(const EffectStage& stage,
                      const EffectFrame& frame,
                      float hidden,
                      const SingleProbeLight& single_probe,
                      const ChangeOf& change_of) {
  const glm::vec3 of_hidden =
      hidden * std::numbers::pi_v<float> * single_probe.LargestRadiance(frame.lighting);
  const auto white = static_cast<float>(1.0 / frame.codes.Exposure());
  float largest = 0.0f;
  for (const SingleProbeLight::Compared& compared : single_probe.Compare(frame.lighting)) {
    const glm::vec3 change = change_of(compared.here, compared.there) + of_hidden;
    const glm::vec3 least = glm::max(compared.here - change, glm::vec3(0.0f));
    // A brighter material shows more of a change, until it is white.
    const glm::vec3 to_radiance = glm::min(kInvPi * stage.LargestAlbedo(),
                                           white / glm::max(compared.here, glm::vec3(1e-30f)));
    largest = std::max(largest, frame.codes.LargestRise(to_radiance * least, to_radiance * change));
  }
  return largest;
}

}  // namespace pleinair

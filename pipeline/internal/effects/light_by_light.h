// Results that are gathered once by rays, then computed for each light, then summed.
#pragma once

#include <cstddef>
#include <vector>

#include "objects/frame_basis.h"
#include "objects/learned_cost.h"
#include "objects/vertex_light.h"
#include "pipeline/internal/effects/frame_effect.h"
#include "scene/state_id.h"

namespace pleinair {

// The key of cast rays. Another number of lights is another basis.
struct GatheredFor {
  ViewOfPose place;
  std::size_t lights = 0;
  bool operator==(const GatheredFor&) const = default;
};

// The key of computed lights: the rays, and the way in which light on the objects was computed.
struct LitFor {
  GatheredFor rays;
  VertexLight::Mode light;
  bool operator==(const LitFor&) const = default;
};

// The lights that were computed.
struct LitByLight {
  LightsDone done;
  std::vector<StateId> made_from;  // The ResultId of the objects' light, by basis light.
};

// Learned costs of the three steps.
struct LightByLightCosts {
  LearnedCost gather;
  LearnedCost light;
  LearnedCost sum;

  WorkCost Of(bool is_new, std::size_t lights) const;
};

// Lights that were never computed, even if they do not shine, so that the sum over all of them is
// defined.
std::vector<std::size_t> LightsToDo(const LightsDone& done,
                                    bool is_new,
                                    const EffectFrame& frame,
                                    Refresh refresh = Refresh::kStale);
// The same, plus the lights whose light on the objects, `source`, has been recomputed since.
std::vector<std::size_t> LightsToDo(const LitByLight& lit,
                                    const LightsDone& source,
                                    bool is_new,
                                    const EffectFrame& frame,
                                    Refresh refresh = Refresh::kStale);
// Records that a light was computed.
void NoteLight(const EffectFrame& frame,
               std::size_t light,
               const LightsDone& source,
               LitByLight& lit);

}  // namespace pleinair

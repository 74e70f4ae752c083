// Something that rays have gathered once, then is worked out light by light, then summed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "objects/frame_basis.h"
#include "objects/learned_cost.h"
#include "objects/vertex_light.h"
#include "pipeline/effects/frame_effect.h"

namespace pleinair {

// What rays were cast for. Another number of lights is another basis.
struct GatheredFor {
  ViewOfPose place;
  std::size_t lights = 0;
  bool operator==(const GatheredFor&) const = default;
};

// What lights were worked out for: the rays, and the way that light on the objects was found.
struct LitFor {
  GatheredFor rays;
  VertexLight::Mode light;
  bool operator==(const LitFor&) const = default;
};

// The lights that were worked out.
struct LitByLight {
  LightsDone done;
  std::vector<std::uint64_t> made_from;  // By light: stamp of the objects' light.
};

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
                                    Upto upto = Upto::kCurrent);
// The same, and lights whose light on the objects, `source`, has been recomputed since.
std::vector<std::size_t> LightsToDo(const LitByLight& lit,
                                    const LightsDone& source,
                                    bool is_new,
                                    const EffectFrame& frame,
                                    Upto upto = Upto::kCurrent);
// Notes that a light was worked out.
void NoteLight(const EffectFrame& frame,
               std::size_t light,
               const LightsDone& source,
               LitByLight& lit);

}  // namespace pleinair

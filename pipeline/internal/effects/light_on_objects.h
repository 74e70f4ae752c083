// How light on virtual objects is computed in a frame, and the cost of each way. It is computed at
// their vertices or at a single probe. It includes the light that they hide from and reflect to
// each other, or does not.
#pragma once

#include <span>

#include "objects/vertex_light.h"
#include "pipeline/internal/effects/frame_effect.h"

namespace pleinair {

// Effects that need light on the objects.
inline constexpr EffectSet kOnLightAtVertices{Effect::kProbeShading,
                                              Effect::kDaylight,
                                              Effect::kSkyOcclusion,
                                              Effect::kColourBleeding,
                                              Effect::kGlossyReflection};

// The way that light is computed where these effects are run.
VertexLight::Mode ModeOfLight(const VertexLight& light, EffectSet runs);

// Returns the costs of each way for the lights that shine in `lighting`.
LightCosts CostsOfLight(const VertexLight& light,
                        const FrameBasis& basis,
                        const Lighting& lighting);

// The cost of drawing samples of the sky.
WorkCost CostOfDaylight(const VertexLight& light, const FrameBasis& basis);

// Which of the effects that decide on the way of light are likely to be run, and whether that light
// is sure to be needed. Then it is computed before the plan, as it makes other bounds tighter.
struct LikelyLight {
  EffectSet effects;
  bool is_sure = false;
};

// `offers` by Effect; only those of kDecideOnLight are used.
LikelyLight LikelyLightOf(const EffectSettings& settings,
                          std::span<const EffectOffer> offers,
                          const LightCosts& costs);

// Effects whose offers come first, as they decide how light on the objects is computed.
inline constexpr EffectSet kDecideOnLight{
    Effect::kProbeShading, Effect::kLocalLight, Effect::kAmbientOcclusion, Effect::kDaylight};

}  // namespace pleinair

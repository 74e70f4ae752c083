// How light on virtual objects is computed in a frame: at their vertices or at a single probe, with
// or without what they hide from and reflect to each other; and the cost of each of these ways.
#pragma once

#include <span>

#include "objects/vertex_light.h"
#include "pipeline/effects/frame_effect.h"

namespace pleinair {

// Effects that need light on the objects.
inline constexpr EffectSet kOnLightAtVertices{Effect::kProbeShading,
                                              Effect::kDaylight,
                                              Effect::kSkyOcclusion,
                                              Effect::kColourBleeding,
                                              Effect::kGlossyReflection};

// The way that light is found where these effects are run.
VertexLight::Mode ModeOfLight(const VertexLight& light, EffectSet runs);

LightCosts CostsOfLight(const VertexLight& light,
                        const FrameBasis& basis,
                        const Lighting& lighting);

// The cost of drawing samples of the sky.
WorkCost CostOfDaylight(const VertexLight& light, const FrameBasis& basis);

// What is likely to be run of the effects that say how light is found, and whether it is sure to be
// needed: then it is made before the plan, as what it brings makes other bounds closer.
struct LikelyLight {
  EffectSet effects;
  bool is_sure = false;
};

// `offers` by Effect: those of kDecideOnLight are looked at.
LikelyLight LikelyLightOf(const EffectSettings& settings,
                          std::span<const EffectOffer> offers,
                          const LightCosts& costs);

// Effects whose offers come first, as light on the objects is found by them.
inline constexpr EffectSet kDecideOnLight{
    Effect::kProbeShading, Effect::kLocalLight, Effect::kAmbientOcclusion, Effect::kDaylight};

}  // namespace pleinair

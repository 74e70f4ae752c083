// Shadows, or their absence, in a picture where the mesh has no caster: trees, cars, cranes.
#pragma once

#include <array>
#include <span>

#include "estimation/diffuse_sample.h"
#include "estimation/sky_climate.h"

namespace pleinair {

// Evidence of shadows in one picture.
struct ShadowCues {
  int shaded = 0;     // Samples found in a shadow that the mesh does not cast.
  bool flat = false;  // A large plane is lit evenly.
};

// Uses pictures in which the mesh casts no shadow, and there planes that the model has in the sun.
// Two levels of light on such a plane, of which the darker is bluer, are sun and shade. The sun's
// direct part is then removed from the transport of the darker samples, so that the contrast is
// evidence of sun over sky. The dark side of an albedo's edge is not bluer, or not as much as sky
// light is. An evenly lit plane is evidence that nothing casts a shadow on it.
//
// Not for albedos from a survey map, which holds the shadows of its own time.
// Source  The change of hue at shadow edges: Finlayson, Drew and Lu, ECCV 2004.
ShadowCues FindShadows(std::span<DiffuseSample> samples);

// Log-likelihood of the cues under each state of the sky: in sunshine most views have some shadow
// in them.
std::array<double, kSkyStates> LogLikelihood(const ShadowCues& cues);

}  // namespace pleinair

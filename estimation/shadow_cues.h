// Shadows, and their absence, that a picture shows where the mesh has no caster: trees, cars,
// cranes.
#pragma once

#include <array>
#include <span>

#include "estimation/diffuse_sample.h"
#include "estimation/sky_climate.h"

namespace pleinair {

struct ShadowCues {
  int shaded = 0;     // Samples found in a shadow that the mesh does not cast.
  bool flat = false;  // A large plane is lit evenly.
};

// Looks at pictures in which the mesh casts no shadow, and there at planes that the model has in
// the sun. Two levels of light on such a plane, of which the darker is bluer, are sun and shade:
// the sun's direct part is taken out of the transport of the darker samples, so that the contrast
// is evidence of sun over sky. An albedo's edge is not bluer on its dark side by itself, or not by
// as much as sky light is. A plane that is lit evenly says that nothing casts a shadow on it.
//
// Not for albedos from a survey map, which holds the shadows of its own time.
// Source  The change of hue at shadow edges: Finlayson, Drew and Lu, ECCV 2004.
ShadowCues FindShadows(std::span<DiffuseSample> samples);

// Of the cues under each state of the sky, as logarithms: where the sun is out most views have some
// shadow in them.
std::array<double, kSkyStates> LogLikelihood(const ShadowCues& cues);

}  // namespace pleinair

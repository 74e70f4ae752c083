// What the clear sky says of light whose units are not known.
#pragma once

#include "estimation/lighting_prior.h"
#include "estimation/rough_light.h"

namespace pleinair {

// Puts the clear sky's ratio of sun to sky into `prior` as a Gaussian at the light that `rough`
// speaks for, in place of sun_to_sky_rgb. With B = sun + ratio * sky it says
//   u = (sun - kSunPriorMean * ratio * sky) / B = 0, give or take two thirds of kSunPriorSigma,
// linear about `rough`. u does not change when all light does, and neither does its derivative's
// word: sun and sky share a rise of the exposure. Rows whose denominators follow the light that is
// found draw it towards 0 instead, where the sun is far from its mean: without any sun to a dark
// sky.
void UseRelativeClearSky(const RoughLight& rough, LightingPrior& prior);

}  // namespace pleinair

// A fit of light that keeps nothing for the next one.
#pragma once

#include <span>

#include "estimation/lighting_fit.h"

namespace pleinair {

inline LightingFit FitLighting(std::span<const DiffuseSample> samples,
                               const LightingPrior& prior,
                               bool sun_is_up,
                               const LightingFitOptions& options = {}) {
  return LightingFitter(options).Fit(samples, prior, sun_is_up);
}

}  // namespace pleinair

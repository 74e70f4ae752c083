// How uncertain one measured channel is before the fit has scaled it.
#pragma once

#include "estimation/lighting_fit.h"

namespace pleinair::estimation_internal {

// Errors of albedo and model grow with the radiance itself, so a residual is measured in units of
// the predicted radiance. Predicted, not measured: the estimating equation
//   sum transport (radiance - predicted) / predicted^2 = 0
// is then free of bias, where weights from the noisy measurement would favour dark samples.
// `floor` stands for what does not shrink with it; camera noise counts in units of the noise that
// is expected of the model.
struct NoiseUnits {
  double floor_squared;
  double per_camera_noise_squared;

  explicit NoiseUnits(const LightingFitOptions& options)
      : floor_squared(options.noise_floor * options.noise_floor),
        per_camera_noise_squared(1.0 / (options.expected_noise * options.expected_noise)) {}

  // One over the noise's variance; 0 for weight 0.
  double InverseSquare(double predicted, double camera_noise, double weight) const {
    return weight / (predicted * predicted + floor_squared +
                     weight * camera_noise * camera_noise * per_camera_noise_squared);
  }
};

}  // namespace pleinair::estimation_internal

// The uncertainty of one measured channel before the fit has scaled it.
#pragma once

#include "estimation/lighting_fit.h"

namespace pleinair::estimation_internal {

// Errors of albedo and model grow with the radiance itself, so a residual is measured in units of
// the predicted radiance. With the predicted radiance the estimating equation sum transport
// (radiance - predicted) / predicted^2 = 0 is free of bias; weights from the noisy measurement
// would favour dark samples. `floor` is the noise that does not decrease with the radiance. Camera
// noise is in units of the model's expected noise.
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

// The robust, non-negative fit of sun and sky to diffuse samples: from numbers to numbers.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_fit_options.h"
#include "estimation/lighting_prior.h"

namespace pleinair {

// LightingFitOptions::sky_shape_error of one shape alone: a wall under an overcast sky gets 0.40 of
// the horizontal irradiance, under a clear one about 0.7, under a uniform one 0.5.
inline constexpr double kLoneSkyShapeError = 0.2;

// The fit under one of the prior's weathers.
struct WeatherFit {
  double share = 0.0;         // Share of the posterior.
  double gain = 1.0;          // Scale of the prior's light in this picture, where it was free.
  double log_evidence = 0.0;  // Evidence of the samples, up to a constant.
  SunAndSky light = SunAndSky::Zero();  // 0 for a weather with a negligible share.
};

// The result. Irradiances in units of radiance times sr: sun normal to the beam, sky horizontal.
struct LightingFit {
  // sun RGB, sky[0] RGB, ...: irradiance, >= 0. Between the mean over the weathers and the light of
  // the most likely one.
  LightVector irradiance_rgb;
  // Covariance of the mixture over the weathers about irradiance_rgb, prior included; one-sided at
  // a bound.
  LightMatrix covariance;
  // In the order of the prior's weathers; a single one where it has none.
  std::vector<WeatherFit> weathers;
  // Covariance of sun and entire sky from the samples and the shapes' prior; large where these do
  // not determine them.
  SunAndSkyMatrix data_covariance;
  // LightingPrior::camera as fitted, prior included: a share of the mean picture, a share of the
  // light in the corners, a share of colours' distance from grey, and g.
  double veil = 0.0;
  double vignetting = 0.0;
  double vignetting_stddev = 0.0;
  double saturation = 0.0;
  double saturation_stddev = 0.0;
  double exponent = 0.0;
  double exponent_stddev = 0.0;
  // Factor of the camera's errors on light as bright as the samples': 1 without errors.
  glm::dvec3 picture_over_light_rgb{1.0};
  // Standard deviation of the sun from the samples only; large but finite where they do not
  // determine it.
  glm::dvec3 sun_stddev_data_rgb{0.0};
  // Ratio of the extreme singular values of the whitened data Jacobian, with sun and sky in one
  // unit and without the prior. Infinite where the samples cannot distinguish the two at all.
  double condition_number = 0.0;

  int samples_used = 0;
  int samples_ignored = 0;       // Not finite, without weight, or without response to any light.
  double inlier_fraction = 0.0;  // Share of the used samples with a robust weight above 0.
  std::vector<std::int32_t> inliers;  // Their indices in the samples given.
  double relative_residual = 0.0;     // Weighted rms over the used samples.
  double shared_error = 0.0;          // As fitted: see LightingFitOptions::shared_error.
  bool sun_is_fitted = true;          // False: held at 0.
  int passes = 0;
  bool converged = false;
};

// Architecture, section 4: the sun is observable where the samples alone determine it to better
// than 15 % of the clear-sky beam.
inline constexpr double kObservableSunSigma = 0.15;

// Whether the samples of `fit` determine the sun; `clear_sky_beam` is the mean over RGB.
bool DeterminesSun(const LightingFit& fit, double clear_sky_beam);

// Where a fit starts.
enum class FitStart {
  kLast,    // At the last fit's light, where it explains the samples as well; else as kRobust.
  kRobust,  // At the robust start: for a frame of another time or place.
};

// Minimises, over P >= 0 and with sun and sky as unknowns per channel,
//   sum_i rho(d_i) + prior,   d_i^2 = mean over RGB of ((radiance - predicted) / noise)^2,
// where the noise is proportional to the predicted radiance. Errors that samples of one plane share
// are whitened (generalised least squares; see internal/reweighting.h).
//
// Units    Scale-free: radiances times f give irradiances times f.
// Samples  Their order does not change a bit of the result. Those that are not finite are ignored
//          and counted.
// Threads  One at a time. Keeps its memory from call to call: reuse it from frame to frame.
class LightingFitter {
 public:
  explicit LightingFitter(const LightingFitOptions& options);
  ~LightingFitter();
  LightingFitter(LightingFitter&&) noexcept;
  LightingFitter& operator=(LightingFitter&&) noexcept;

  // Returns the fitted light. `sun_is_up` false holds the sun at 0. Without any sample the result
  // is the prior's.
  // Throws std::invalid_argument where prior.sky_shapes is outside 1 .. kMaxSkyShapes or does not
  // fit the prior's matrices, or prior.beam_shape is not below it.
  LightingFit Fit(std::span<const DiffuseSample> samples,
                  const LightingPrior& prior,
                  bool sun_is_up,
                  FitStart start = FitStart::kLast);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Sets is_rejected of all samples. They are those that `fit` was computed from.
void MarkRejected(const LightingFit& fit, std::span<DiffuseSample> samples);

}  // namespace pleinair

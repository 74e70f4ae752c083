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

// What the fit found under one of the prior's weathers.
struct WeatherFit {
  double share = 0.0;                   // Of the posterior.
  double gain = 1.0;                    // Of the prior's light in this picture, where it was free.
  double log_evidence = 0.0;            // Of the samples, but for a constant.
  SunAndSky light = SunAndSky::Zero();  // 0 for a weather without a share worth mentioning.
};

struct LightingFit {
  // sun RGB, sky[0] RGB, ...: irradiance, >= 0. Between the mean over the weathers and the light of
  // the most likely one.
  LightVector irradiance_rgb;
  // Of the mixture over the weathers about irradiance_rgb, prior included; one-sided at a bound.
  LightMatrix covariance;
  // In the order of the prior's weathers; one where it has none.
  std::vector<WeatherFit> weathers;
  // Of sun and whole sky, by the samples and the shapes' prior; large where they cannot say.
  SunAndSkyMatrix data_covariance;
  // LightingPrior::camera as found, prior included: a share of the mean picture, and g.
  double veil = 0.0;
  double exponent = 0.0;
  double exponent_stddev = 0.0;
  // What the camera's errors make of light as bright as the samples': 1 where there are none.
  glm::dvec3 picture_over_light_rgb{1.0};
  // Of the sun, from the samples alone; large but finite where they cannot tell.
  glm::dvec3 sun_stddev_data_rgb{0.0};
  // Ratio of the extreme singular values of the whitened data Jacobian, sun and sky in one unit, no
  // prior; infinite where the samples cannot tell the two apart at all.
  double condition_number = 0.0;

  int samples_used = 0;
  int samples_ignored = 0;       // Not finite, without weight, or without response to any light.
  double inlier_fraction = 0.0;  // Share of the used samples that the robust weight did not reject.
  std::vector<std::int32_t> inliers;  // Those, by their index in what was fitted to.
  double relative_residual = 0.0;     // Weighted rms over the used samples.
  double shared_error = 0.0;          // As found: see LightingFitOptions::shared_error.
  double sky_shape_error = 0.0;       // Likewise.
  bool sun_is_fitted = true;          // False: held at 0.
  int passes = 0;
  bool converged = false;
};

// Architecture, section 4: the samples alone know the sun to better than 15 % of the clear-sky
// beam.
inline constexpr double kObservableSunSigma = 0.15;

// Whether the samples of `fit` tell the sun; `clear_sky_beam` is the mean over RGB.
bool TellsTheSun(const LightingFit& fit, double clear_sky_beam);

// Minimises, over P >= 0 and with sun and sky as unknowns per channel,
//   sum_i rho(d_i) + prior,   d_i^2 = mean over RGB of ((radiance - predicted) / noise)^2,
// where the noise is proportional to the predicted radiance, and the errors that samples of one
// plane share are whitened out (generalised least squares; internal/reweighting.h says how).
//
// Scale-free: radiances times f give irradiances times f. The order of the samples does not change
// a bit. Samples that are not finite are ignored and counted.
// Keeps its memory from call to call: reuse it from frame to frame. Not for two threads at once.
class LightingFitter {
 public:
  explicit LightingFitter(const LightingFitOptions& options);
  ~LightingFitter();
  LightingFitter(LightingFitter&&) noexcept;
  LightingFitter& operator=(LightingFitter&&) noexcept;

  // `sun_is_up` false holds the sun at 0. Works without any sample: then the prior answers.
  // Throws std::invalid_argument when prior.sky_shapes does not fit its matrices.
  LightingFit Fit(std::span<const DiffuseSample> samples,
                  const LightingPrior& prior,
                  bool sun_is_up);

  // The next fit does not start at the last one's light: for a frame of another time or place.
  void Forget();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The same, set up for one call.
LightingFit FitLighting(std::span<const DiffuseSample> samples,
                        const LightingPrior& prior,
                        bool sun_is_up,
                        const LightingFitOptions& options = {});

// Sets is_rejected of all samples, which `fit` was made from.
void MarkRejected(const LightingFit& fit, std::span<DiffuseSample> samples);

}  // namespace pleinair

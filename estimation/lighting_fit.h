// The robust, non-negative fit of sun and sky to diffuse samples: from numbers to numbers.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include <glm/vec3.hpp>

#include "estimation/diffuse_sample.h"
#include "estimation/lighting_prior.h"

namespace pleinair {

struct LightingFitOptions {
  enum class Solver {
    kCeres,   // The last, bounded solve by Ceres.
    kClosed,  // By the normal equations and an active set: an independent check.
  };
  Solver solver = Solver::kCeres;

  // Tukey's biweight leaves out samples farther than this many robust standard deviations. > 0.
  // 4.685 would keep 95 % of the efficiency on Gaussian noise; 4 keeps 90 % and lets a third less
  // of a moderate outlier through.
  double tukey_width = 4.0;
  // Of a sample's albedo and model, relative, before the data have spoken. It counts as much as one
  // sample, so that a handful of samples cannot claim to be exact. > 0.
  double expected_noise = 0.05;
  // Expected error of the whole prediction that the samples of one plane share, relative: a wall's
  // albedo. >= 0; 0 says that samples err alone.
  double shared_error = 0.05;
  // Expected error of the sky's part of the prediction that the samples of one plane share,
  // relative: a real sky is not of the fitted shape. The data correct it where there are planes
  // enough. Lit and shaded samples of a plane err alike, so that their contrast tells the sun
  // whatever the sky's shape. A tenth is right for a mix of shapes: over 156 measured and modelled
  // skies and views of two scenes the stated deviation of the sky then held 71 % of the truths
  // (0.2: 82 %), with the same errors. >= 0.
  double sky_shape_error = 0.1;
  // Shares of the sky's shapes before the data have spoken: all equal, give or take this. Wider
  // than any mix of fractions, so that it speaks only where the samples cannot: on measured and
  // modelled skies over three scenes a spread of 0.35 cost half as much error again as 1. > 0.
  double shape_share_spread = 1.0;
  // How much the shares of one shape differ from channel to channel: a white cloud before a blue
  // sky takes more of the red than of the blue. > 0.
  double shape_share_colour_spread = 0.5;
  // Noise that does not shrink with a sample's radiance, as a share of the samples' median. > 0.
  double noise_floor = 0.05;
  int max_passes = 40;  // Of reweighting. >= 1.
  std::uint64_t seed = 1;

  // Throws std::invalid_argument naming field and value.
  void Validate() const;
};

// LightingFitOptions::sky_shape_error of one shape alone: a wall under an overcast sky gets 0.40 of
// the horizontal irradiance, under a clear one about 0.7, under a uniform one 0.5.
inline constexpr double kLoneSkyShapeError = 0.2;

struct LightingFit {
  // sun RGB, sky[0] RGB, ...: irradiance, >= 0.
  LightVector irradiance_rgb;
  // Of the unbounded fit at the solution, prior included.
  LightMatrix covariance;
  // What the samples alone say, as an inverse covariance; never singular (see lighting_fit.cpp, the
  // weak prior).
  LightMatrix data_information;
  // Of the sun, from the samples alone; large but finite where they cannot tell.
  glm::dvec3 sun_stddev_data_rgb{0.0};
  // Ratio of the extreme singular values of the whitened data Jacobian, sun and sky in one unit, no
  // prior; infinite where the samples cannot tell the two apart at all.
  double condition_number = 0.0;

  int samples_used = 0;
  int samples_ignored = 0;       // Not finite, without weight, or without response to any light.
  double inlier_fraction = 0.0;  // Share of the used samples that the robust weight did not reject.
  double relative_residual = 0.0;  // Weighted rms over the used samples.
  double shared_error = 0.0;       // As found: see LightingFitOptions::shared_error.
  double sky_shape_error = 0.0;    // Likewise.
  bool sun_is_fitted = true;       // False: held at 0.
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

}  // namespace pleinair

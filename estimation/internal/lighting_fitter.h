// The fit's steps and what it keeps from call to call: of lighting_fit.cpp, which finds the light,
// and lighting_fit_description.cpp, which says how well.
#pragma once

#include "estimation/internal/ceres_solve.h"
#include "estimation/internal/fit_problem.h"
#include "estimation/internal/reweighting.h"
#include "estimation/internal/robust_start.h"
#include "estimation/internal/weather_mixture.h"
#include "estimation/lighting_fit.h"

namespace pleinair {

namespace estimation_internal {

// The weak prior: an unknown of 0, give or take a hundred times the light that explains the median
// sample. It keeps every matrix regular, and costs a fit that 10 samples with 5 % of noise carry
// (100)^-2 / (10 / 0.05^2) < 1e-7 of itself.
inline constexpr double kWeakInformation = 1e-4;

}  // namespace estimation_internal

// Replaces `fit` by a mixture of itself and `other`, which has the smaller part `share`.
void Blend(const LightingFit& other, double share, LightingFit& fit);

struct LightingFitter::Impl {
  const LightingFitOptions given_options;
  LightingFitOptions options;  // For this call: the prior may state less certain albedos.
  estimation_internal::FitProblem problem;
  estimation_internal::RobustStart start;
  estimation_internal::Reweighting reweighting;
  estimation_internal::WeatherMixture mixture;
  estimation_internal::CeresSolver ceres;

  // In the fit's own units and order: the common factor of the prior.
  LightMatrix prior_information;
  LightVector prior_gradient;
  LightMatrix fixed_prior_information;  // Without the rows that are relative to the light found.

  // The last call's result, in the prior's units and order; empty before.
  LightVector last_irradiance_rgb;
  bool restarted = true;                           // This call, at no earlier light.
  bool is_ambiguous = false;                       // It found two lights that may both be.
  estimation_internal::ErrorVector camera_errors;  // In standard deviations.

  explicit Impl(const LightingFitOptions& fit_options)
      : given_options(fit_options), options(fit_options) {
    options.Validate();
  }

  // The samples, of whose radiances `exponent` is taken out, and the prior.
  void Load(std::span<const DiffuseSample> samples,
            const LightingPrior& prior,
            bool sun_is_up,
            double exponent);
  // Sets the camera's errors to what the prior expects.
  void ExpectErrors();
  void LoadPrior(const LightingPrior& prior);
  double BeamIn(const LightingPrior& prior, const LightVector& x) const;
  void AddShapePrior(const LightingPrior& prior, const LightVector& x);
  LightVector Begin();
  // A start of the fit with a sun as strong as in the brightest weather for the sky of `x`. Empty
  // where `x` has such a sun already, or nothing is known of weathers.
  LightVector WithSun(const LightingPrior& prior, const LightVector& x) const;
  LightVector FitFrom(const LightingPrior& prior, LightVector x, LightingFit& fit);
  void WeighAgainstHiddenSun(const LightingPrior& prior, const LightVector& x, LightingFit& fit);
  // The samples' evidence of lights and camera errors together; the errors come last and include
  // their prior.
  estimation_internal::Evidence WithErrors() const;
  estimation_internal::Evidence WithoutErrors(
      const estimation_internal::Evidence& with_errors) const;
  void FindErrors(const estimation_internal::Evidence& with_errors, const LightVector& x);
  estimation_internal::Evidence WithPrior(const estimation_internal::Evidence& samples) const;
  LightVector Iterate(const LightingPrior& prior, LightVector x, LightingFit& fit);
  LightMatrix SampleVariance() const;
  LightMatrix CovarianceOf(const estimation_internal::WeatherSolution& solution,
                           const estimation_internal::Evidence& with_errors,
                           const LightMatrix& variance) const;
  void WidenAtBounds(const estimation_internal::WeatherSolution& solution,
                     const estimation_internal::Evidence& evidence,
                     LightMatrix& covariance) const;
  void Describe(const LightingPrior& prior, const LightVector& x, LightingFit& fit) const;
  glm::dvec3 PictureOverLight(const LightVector& x) const;
  void DescribeCamera(const CameraErrors& camera,
                      const estimation_internal::Evidence& with_errors,
                      LightingFit& fit) const;
  double ConditionNumber(const LightMatrix& normal) const;
  void DescribeWeathers(const LightMatrix& normal, LightingFit& fit) const;
};

}  // namespace pleinair

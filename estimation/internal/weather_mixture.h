// The prior's weathers in the fit's own units, and how well each explains the samples.
#pragma once

#include <array>
#include <vector>

#include "estimation/internal/ceres_solve.h"
#include "estimation/internal/fit_problem.h"
#include "estimation/lighting_prior.h"

namespace pleinair::estimation_internal {

// Evidence of the samples and the common factor of the prior. Minus twice its logarithm is
//   x' normal x - 2 x' gradient + constant.
struct Evidence {
  LightMatrix normal;
  LightVector gradient;
};

// The solution under one weather.
struct WeatherSolution {
  double share = 0.0;       // Share of the posterior.
  LightVector light;        // The minimiser over lights >= 0.
  LightMatrix information;  // Of the weather only.
  LightVector information_times_mean;
  double gain = 1.0;          // Scale of the prior's light in this picture.
  double log_evidence = 0.0;  // Of the samples, up to a constant.
};

// Gaussians over the sums that a prior describes: sun and entire sky per channel.
class WeatherMixture {
 public:
  // Reads the units of `problem`; keeps no reference.
  void Load(const LightingPrior& prior, const FitProblem& problem);

  // Finds the gain of each weather where it is free: the one under which its mean light explains
  // the samples best. Without samples it is 1.
  void ChooseGains(const Evidence& samples);

  // The solutions of those weathers that the last call found likely, or of all.
  enum class Which { kLikely, kAll };
  void Solve(const Evidence& evidence, Which which);

  // Solves for the likely weathers again, by Ceres. False where one does not settle: it stays.
  bool Refine(const Evidence& evidence, CeresSolver& ceres);

  const std::vector<WeatherSolution>& Solutions() const { return solutions_; }
  // The mean of the weathers' lights weighted by the cubes of their shares. It lies between their
  // mean, which may resemble no weather where they are far apart, and the most likely light.
  LightVector Light() const;
  // Information of the most likely weather.
  const LightMatrix& Information() const;
  // Weathers with a smaller share are neglected.
  static constexpr double kLeastShare = 1e-3;

 private:
  struct Weather {
    double log_share = 0.0;
    double last_log_evidence = 0.0;
    double log_likelihood = 0.0;  // Of other evidence in the picture.
    LightGaussian light;          // In the fit's units, with a gain of 1.
    // With the gain as chosen.
    SunAndSkyMatrix information;
    SunAndSky information_times_mean;
    double mean_square = 0.0;  // mean' information mean.
    double log_determinant = 0.0;
  };

  bool has_sun_ = false;
  int basis_count_ = 0;
  bool gain_is_free_ = false;
  double channel_gain_stddev_ = 0.0;
  double repeats_ = 0.0;
  std::size_t likeliest_before_ = 0;
  std::vector<Weather> weathers_;
  std::vector<WeatherSolution> solutions_;

  double News(std::size_t weather) const;
  int SumOf(Eigen::Index unknown) const;
  void SetInformation(Weather& weather, double gain);
};

}  // namespace pleinair::estimation_internal

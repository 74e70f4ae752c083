// A first guess that a large minority of wrong samples cannot pull away.
#pragma once

#include <vector>

#include "estimation/internal/fit_problem.h"
#include "estimation/internal/noise_units.h"

namespace pleinair::estimation_internal {

// Least median of squares over solutions of random pairs, one sample of each that sees much sun and
// one that sees little (Rousseeuw, Journal of the American Statistical Association 79, 1984). All
// sky shapes count as equally strong.
class RobustStart {
 public:
  // Unknowns of `problem`, all >= 0. The same problem and seed give the same answer.
  LightVector Find(const FitProblem& problem, const NoiseUnits& noise, std::uint64_t seed);

 private:
  std::vector<int> by_sun_share_;
  std::vector<double> sun_share_;
  std::vector<double> deviation_;

  void SplitBySunShare(const FitProblem& problem);
  double MedianDeviation(const FitProblem& problem, const NoiseUnits& noise, const LightVector& x);
};

}  // namespace pleinair::estimation_internal

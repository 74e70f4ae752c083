// A first guess that a large minority of wrong samples cannot pull away.
#pragma once

#include <array>
#include <vector>

#include "estimation/internal/fit_problem.h"
#include "estimation/internal/noise_units.h"

namespace pleinair::estimation_internal {

struct TwoLights {
  double sun = 0.0;
  double sky = 0.0;  // Of each shape.
};

// Least truncated squares over solutions of random pairs, one sample of each that sees much sun and
// one that sees little (Rousseeuw, Journal of the American Statistical Association 79, 1984). All
// sky shapes count as equally strong.
class RobustStart {
 public:
  // Unknowns of `problem`, all >= 0. The same problem and seed give the same answer.
  LightVector Find(const FitProblem& problem, const NoiseUnits& noise, std::uint64_t seed);

 private:
  // What one channel of one judging sample says.
  struct Witness {
    double radiance;
    double sun_transport;
    double sky_transport;  // Of all shapes together.
    double noise;
    double weight;
  };

  std::vector<int> by_sun_share_;
  std::vector<double> sun_share_;
  std::vector<Witness> witnesses_;  // RGB of each judge.

  void SplitBySunShare(const FitProblem& problem);
  void GatherWitnesses(const FitProblem& problem);
  double TruncatedDeviation(const NoiseUnits& noise, const std::array<TwoLights, 3>& lights);
};

}  // namespace pleinair::estimation_internal

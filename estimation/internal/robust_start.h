// A first guess that a large minority of wrong samples cannot pull away.
#pragma once

#include <array>
#include <cstdint>
#include <span>
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
// sky shapes count as equally strong. A shadow that the mesh lacks may lie on any part of a plane,
// at the price of its improbability; light that no sky explains has no such excuse. So a few
// samples in the sun outweigh many that only the mesh has there.
class RobustStart {
 public:
  // Unknowns of `problem`, all >= 0. The same problem and seed give the same answer.
  // `shared_error`: of each plane's albedo, relative. Lit and shaded samples of a plane share it,
  // so that where albedos are but guessed their contrast says the most of the light.
  LightVector Find(const FitProblem& problem,
                   const NoiseUnits& noise,
                   double shared_error,
                   std::uint64_t seed);

  // How much better `b` explains the judges than `a`, as a logarithm of odds: by the measure that
  // Find goes by, its shadows included.
  double LogOdds(const FitProblem& problem,
                 const NoiseUnits& noise,
                 double shared_error,
                 const LightVector& a,
                 const LightVector& b);

 private:
  // What one channel of one judging sample says.
  struct Witness {
    double radiance;
    double sun_transport;
    double sky_transport;  // Of all shapes together.
    double noise;
    double weight;
    std::int32_t plane;
    double Predicted(const TwoLights& light) const {
      return light.sun * sun_transport + light.sky * sky_transport;
    }
  };

  std::vector<int> by_sun_share_;
  std::vector<double> sun_share_;
  std::vector<Witness> witnesses_;  // RGB of each judge, plane by plane.
  std::vector<double> ratios_;

  void SplitBySunShare(const FitProblem& problem);
  // Transports in the light that `unit` gives for (channel, basis).
  template <class Unit>
  void GatherWitnesses(const FitProblem& problem, const Unit& unit);
  double DeviationOf(const FitProblem& problem,
                     const NoiseUnits& noise,
                     double shared_error,
                     const LightVector& x);
  double AlbedoError(std::size_t first,
                     std::size_t last,
                     std::size_t channel,
                     const TwoLights& light,
                     double shared_error);
  // Of all witnesses; from `enough` on it need not be complete: those lights are not the best.
  double TruncatedDeviation(const NoiseUnits& noise,
                            const std::array<TwoLights, 3>& lights,
                            double shared_error,
                            double enough);
  // Of one plane's witnesses.
  static double TruncatedDeviation(const NoiseUnits& noise,
                                   const std::array<TwoLights, 3>& lights,
                                   std::span<const Witness> witnesses);
};

}  // namespace pleinair::estimation_internal

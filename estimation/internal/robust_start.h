// A robust first guess: a large minority of wrong samples does not change it.
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
  double sky = 0.0;  // For each shape.
};

// Least truncated squares over solutions of random pairs, one sample of each that sees much sun and
// one that sees little (Rousseeuw, Journal of the American Statistical Association 79, 1984). All
// sky shapes count as equally strong. A shadow that the mesh lacks may lie on any part of a plane,
// with a penalty for its improbability. Light that no sky explains has no such explanation. So a
// few samples in the sun outweigh many that are in the sun only by the mesh.
class RobustStart {
 public:
  // Unknowns of `problem`, all >= 0. The same problem and seed give the same answer.
  // `shared_error` is the error of each plane's albedo, relative. Lit and shaded samples of a plane
  // share it, so that with guessed albedos their contrast is the best evidence of the light.
  LightVector Find(const FitProblem& problem,
                   const NoiseUnits& noise,
                   double shared_error,
                   std::uint64_t seed);

  // Log odds of `b` over `a` by the judging samples, with the measure that Find uses, its shadows
  // included.
  double LogOdds(const FitProblem& problem,
                 const NoiseUnits& noise,
                 double shared_error,
                 const LightVector& a,
                 const LightVector& b);

 private:
  // One channel of one judging sample.
  struct Witness {
    double radiance;
    double sun_transport;
    double sky_transport;  // Sum over the shapes.
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
  // Sum over all witnesses. It may stop at `enough`: such lights are not the best.
  double TruncatedDeviation(const NoiseUnits& noise,
                            const std::array<TwoLights, 3>& lights,
                            double shared_error,
                            double enough);
  // Sum over one plane's witnesses.
  static double TruncatedDeviation(const NoiseUnits& noise,
                                   const std::array<TwoLights, 3>& lights,
                                   std::span<const Witness> witnesses);
};

}  // namespace pleinair::estimation_internal

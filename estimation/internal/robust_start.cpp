#include "estimation/internal/robust_start.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "estimation/internal/missing_sun.h"
#include "estimation/internal/random.h"
#include "estimation/internal/square.h"
#include "scene/upper_median.h"

namespace pleinair::estimation_internal {
namespace {

// With 40 % of wrong samples a pair is right with a chance of 0.36: 24 pairs are all wrong with one
// of 2e-5.
constexpr int kPairs = 24;
// Relative: a sample farther from a guess than this is an outlier of it. A median would not do:
// where a quarter of the samples are in the sun, no sun at all explains the most.
constexpr double kOutlierFrom = 0.3;
// Error of a single sample, relative, in addition to its plane's albedo: texture, and what the
// model misses.
constexpr double kOwnError = 0.1;
// Errors that brighten a surface that much are rarer than those that darken it.
constexpr double kBrightOutlierFrom = 0.4;
// Samples that judge a guess: enough to distinguish a right guess from a wrong one.
constexpr int kJudges = 96;

bool IsLit(double predicted, double of_sky) { return predicted - of_sky > kLitFrom * predicted; }

// More than half of it, so that shade is the better explanation.
bool LacksItsSun(double seen, double predicted, double of_sky) {
  return IsLit(predicted, of_sky) && predicted - seen > 0.5 * (predicted - of_sky);
}

// Improbability of a shadow, of any size, on exactly these of a plane's lit samples.
double NatsOfShadow(int shaded, int lit) {
  const double share = static_cast<double>(shaded) / lit;
  double nats = -std::log(kShadeTheMeshLacks) - shaded * std::log(share);
  if (shaded < lit) nats -= (lit - shaded) * std::log1p(-share);
  return nats;
}

// Least-squares light of one kind, where the pair of samples cannot distinguish two.
double OneLight(double t0, double t1, double l0, double l1) {
  const double square = t0 * t0 + t1 * t1;
  return square > 0.0 ? std::max(0.0, (t0 * l0 + t1 * l1) / square) : 0.0;
}

// One channel of a sample.
struct OneSample {
  double sun = 0.0;  // Transport.
  double sky = 0.0;
  double radiance = 0.0;
  bool is_usable = false;
};

TwoLights SolveChannel(const OneSample& a, const OneSample& b) {
  const double determinant = a.sun * b.sky - b.sun * a.sky;
  const double size = std::abs(a.sun * b.sky) + std::abs(b.sun * a.sky);
  // Transports have the error of their albedo, some per cent: below that two lights cannot be
  // distinguished.
  constexpr double kDistinct = 0.02;
  if (!(std::abs(determinant) > kDistinct * size)) {
    return {0.0, OneLight(a.sky, b.sky, a.radiance, b.radiance)};
  }
  const TwoLights both{(a.radiance * b.sky - b.radiance * a.sky) / determinant,
                       (a.sun * b.radiance - b.sun * a.radiance) / determinant};
  if (both.sun >= 0.0 && both.sky >= 0.0) return both;
  if (both.sun < 0.0) return {0.0, OneLight(a.sky, b.sky, a.radiance, b.radiance)};
  return {OneLight(a.sun, b.sun, a.radiance, b.radiance), 0.0};
}

std::array<TwoLights, 3> SolvePair(const FitProblem& problem, int lit, int shaded) {
  const auto read = [&](int sample, int channel) {
    const double* row = problem.Transport(sample, channel);
    const auto v = static_cast<std::size_t>(sample * 3 + channel);
    OneSample seen{problem.has_sun ? row[0] : 0.0, 0.0, problem.radiance[v]};
    for (int j = problem.has_sun ? 1 : 0; j < problem.basis_count; ++j) seen.sky += row[j];
    seen.is_usable = problem.weight[v] > 0.0;
    return seen;
  };
  std::array<TwoLights, 3> lights;
  TwoLights sum;
  for (int c = 0; c < 3; ++c) {
    const OneSample a = read(lit, c);
    const OneSample b = read(shaded, c);
    if (!a.is_usable || !b.is_usable) continue;
    TwoLights& light = lights[static_cast<std::size_t>(c)];
    light = SolveChannel(a, b);
    sum.sun += light.sun;
    sum.sky += light.sky;
  }
  // A channel that is clipped in one of them: sun over sky as in the others.
  for (int c = 0; c < 3; ++c) {
    const OneSample a = read(lit, c);
    const OneSample b = read(shaded, c);
    if (a.is_usable == b.is_usable) continue;
    const OneSample& seen = a.is_usable ? a : b;
    const double response = sum.sun * seen.sun + sum.sky * seen.sky;
    if (!(response > 0.0)) continue;
    const double gain = seen.radiance / response;
    lights[static_cast<std::size_t>(c)] = {gain * sum.sun, gain * sum.sky};
  }
  return lights;
}

// A sample's radiance over its response to the sky.
double OverSky(const FitProblem& problem, int sample) {
  double seen = 0.0;
  double sky = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double* row = problem.Transport(sample, c);
    seen += problem.radiance[static_cast<std::size_t>(sample * 3 + c)];
    for (int j = problem.has_sun ? 1 : 0; j < problem.basis_count; ++j) sky += row[j];
  }
  return sky > 0.0 ? seen / sky : 0.0;
}

}  // namespace

void RobustStart::SplitBySunShare(const FitProblem& problem) {
  const int count = problem.sample_count;
  sun_share_.resize(static_cast<std::size_t>(count));
  by_sun_share_.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    double sun = 0.0;
    double all = 0.0;
    for (int c = 0; c < 3; ++c) {
      const double* row = problem.Transport(i, c);
      if (problem.has_sun) sun += row[0];
      for (int j = 0; j < problem.basis_count; ++j) all += row[j];
    }
    sun_share_[static_cast<std::size_t>(i)] = all > 0.0 ? sun / all : 0.0;
    by_sun_share_[static_cast<std::size_t>(i)] = i;
  }
  std::nth_element(by_sun_share_.begin(),
                   by_sun_share_.begin() + count / 2,
                   by_sun_share_.end(),
                   [&](int a, int b) {
                     const double share_a = sun_share_[static_cast<std::size_t>(a)];
                     const double share_b = sun_share_[static_cast<std::size_t>(b)];
                     return share_a != share_b ? share_a < share_b : a < b;
                   });
}

template <class Unit>
void RobustStart::GatherWitnesses(const FitProblem& problem, const Unit& unit) {
  const int judges = std::min(kJudges, problem.sample_count);
  witnesses_.clear();
  for (int judge = 0; judge < judges; ++judge) {
    const int i =
        static_cast<int>(static_cast<std::int64_t>(judge) * problem.sample_count / judges);
    for (int c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(i * 3 + c);
      const double* row = problem.Transport(i, c);
      Witness witness{problem.radiance[v],
                      0.0,
                      0.0,
                      problem.noise[v],
                      problem.weight[v],
                      problem.plane[static_cast<std::size_t>(i)]};
      if (problem.has_sun) witness.sun_transport = row[0] * unit(c, 0);
      for (int j = problem.has_sun ? 1 : 0; j < problem.basis_count; ++j) {
        witness.sky_transport += row[j] * unit(c, j);
      }
      witnesses_.push_back(witness);
    }
  }
}

// Factor by which the judges first .. last - 1 of one plane are brighter than under `lights`,
// limited by the error of its albedo.
double RobustStart::AlbedoError(std::size_t first,
                                std::size_t last,
                                std::size_t channel,
                                const TwoLights& light,
                                double shared_error) {
  ratios_.clear();
  for (std::size_t judge = first; judge < last; judge += 3) {
    const Witness& witness = witnesses_[judge + channel];
    const double of_sky = light.sky * witness.sky_transport;
    double predicted = witness.Predicted(light);
    if (LacksItsSun(witness.radiance, predicted, of_sky)) predicted = of_sky;
    if (witness.weight > 0.0 && predicted > 0.0 && witness.radiance > 0.0) {
      ratios_.push_back(witness.radiance / predicted);
    }
  }
  if (ratios_.empty()) return 1.0;
  const double count = static_cast<double>(ratios_.size());
  const double known = Square(kOwnError / shared_error);
  return std::pow(UpperMedianInPlace(ratios_), count / (count + known));
}

double RobustStart::TruncatedDeviation(const NoiseUnits& noise,
                                       const std::array<TwoLights, 3>& lights,
                                       double shared_error,
                                       double enough) {
  double total = 0.0;
  for (std::size_t first = 0; first < witnesses_.size() && total < enough;) {
    std::size_t last = first;
    while (last < witnesses_.size() && witnesses_[last].plane == witnesses_[first].plane) last += 3;
    const auto witnesses = std::span(witnesses_).subspan(first, last - first);
    double deviation = TruncatedDeviation(noise, lights, witnesses);
    if (shared_error > 0.0) {
      std::array<TwoLights, 3> on_plane;
      double of_albedo = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double error = AlbedoError(first, last, c, lights[c], shared_error);
        on_plane[c] = {error * lights[c].sun, error * lights[c].sky};
        of_albedo += Square(kOwnError / shared_error * std::log(error)) / 3.0;
      }
      if (of_albedo < deviation) {
        deviation = std::min(deviation, of_albedo + TruncatedDeviation(noise, on_plane, witnesses));
      }
    }
    total += deviation;
    first = last;
  }
  return total;
}

double RobustStart::TruncatedDeviation(const NoiseUnits& noise,
                                       const std::array<TwoLights, 3>& lights,
                                       std::span<const Witness> witnesses) {
  double as_modelled = 0.0;
  double with_shadows = 0.0;
  int lit = 0;
  int shaded = 0;
  for (std::size_t judge = 0; judge < witnesses.size(); judge += 3) {
    double seen = 0.0;
    double all_predicted = 0.0;
    double all_of_sky = 0.0;
    double squares = 0.0;
    double squares_in_shade = 0.0;
    int channels = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const Witness& witness = witnesses[judge + c];
      if (!(witness.weight > 0.0)) continue;
      const auto squared = [&](double predicted) {
        return Square(witness.radiance - predicted) *
               noise.InverseSquare(predicted, witness.noise, witness.weight);
      };
      const double of_sky = lights[c].sky * witness.sky_transport;
      const double predicted = witness.Predicted(lights[c]);
      squares += squared(predicted);
      squares_in_shade += squared(of_sky);
      seen += witness.radiance;
      all_predicted += predicted;
      all_of_sky += of_sky;
      ++channels;
    }
    const double outlier = seen > 2.0 * all_predicted ? kBrightOutlierFrom : kOutlierFrom;
    const double deviation = std::min(squares / channels, Square(outlier));
    as_modelled += deviation;
    lit += IsLit(all_predicted, all_of_sky) ? 1 : 0;
    if (LacksItsSun(seen, all_predicted, all_of_sky)) {
      ++shaded;
      with_shadows += std::min(squares_in_shade / channels, Square(outlier));
    } else {
      with_shadows += deviation;
    }
  }
  if (shaded == 0) return as_modelled;
  return std::min(as_modelled, with_shadows + 2.0 * Square(kOwnError) * NatsOfShadow(shaded, lit));
}

double RobustStart::DeviationOf(const FitProblem& problem,
                                const NoiseUnits& noise,
                                double shared_error,
                                const LightVector& x) {
  GatherWitnesses(problem,
                  [&](int channel, int basis) { return x[channel * problem.basis_count + basis]; });
  return TruncatedDeviation(noise,
                            {{{1.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}}},
                            shared_error,
                            std::numeric_limits<double>::infinity());
}

double RobustStart::LogOdds(const FitProblem& problem,
                            const NoiseUnits& noise,
                            double shared_error,
                            const LightVector& a,
                            const LightVector& b) {
  return (DeviationOf(problem, noise, shared_error, a) -
          DeviationOf(problem, noise, shared_error, b)) /
         (2.0 * Square(kOwnError));
}

LightVector RobustStart::Find(const FitProblem& problem,
                              const NoiseUnits& noise,
                              double shared_error,
                              std::uint64_t seed) {
  // One unit of sky is what explains the median sample of each channel (see FitProblem's units).
  std::array<TwoLights, 3> best;
  for (TwoLights& lights : best) lights.sky = 1.0;
  if (problem.sample_count >= 2) {
    SplitBySunShare(problem);
    GatherWitnesses(problem, [](int, int) { return 1.0; });
    double best_deviation =
        TruncatedDeviation(noise, best, shared_error, std::numeric_limits<double>::infinity());
    const int half = problem.sample_count / 2;
    SplitMix64 random(seed);
    for (int pair = 0; pair < kPairs; ++pair) {
      const auto shaded = static_cast<std::size_t>(random.Below(half));
      const auto draw_lit = [&] {
        return by_sun_share_[static_cast<std::size_t>(half +
                                                      random.Below(problem.sample_count - half))];
      };
      // The brighter of two, as the other may be in a shadow that the mesh lacks.
      const int one = draw_lit();
      const int other = draw_lit();
      const int lit = OverSky(problem, one) < OverSky(problem, other) ? other : one;
      const std::array<TwoLights, 3> lights = SolvePair(problem, lit, by_sun_share_[shaded]);
      const double deviation = TruncatedDeviation(noise, lights, shared_error, best_deviation);
      if (deviation < best_deviation) {
        best_deviation = deviation;
        best = lights;
      }
    }
  }
  LightVector x(problem.UnknownCount());
  for (int c = 0; c < 3; ++c) {
    const TwoLights& lights = best[static_cast<std::size_t>(c)];
    x.segment(c * problem.basis_count, problem.basis_count).setConstant(lights.sky);
    if (problem.has_sun) x[c * problem.basis_count] = lights.sun;
  }
  return x;
}

}  // namespace pleinair::estimation_internal

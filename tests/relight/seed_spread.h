// How light that is drawn at random varies from seed to seed.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "relight/daylight/window_sampling.h"

namespace pleinair {

struct SeedSpread {
  double mean = 0.0;      // Over seeds and receivers, RGB added up.
  double variance = 0.0;  // Over seeds, of each receiver, added up; 0 for one seed.
  int seeds = 0;
  double MeanStddev(std::size_t receivers) const {
    return std::sqrt(variance / seeds) / static_cast<double>(receivers);
  }
};

// What is lit: an object by daylight that comes through windows.
struct DaylitObject {
  std::span<const Window> windows;
  BoundingSphere sphere;
  std::span<const glm::vec3> sky;
};

// Over seeds 1 to `seeds`; `values_of` returns each receiver's light of drawn samples.
template <typename ValuesOf>
SeedSpread SpreadOverSeeds(const DaylitObject& object,
                           DaylightSamplingOptions options,
                           int seeds,
                           const ValuesOf& values_of) {
  std::vector<double> sum;
  std::vector<double> squares;
  for (int seed = 1; seed <= seeds; ++seed) {
    options.seed = static_cast<std::uint64_t>(seed);
    const std::vector<double> values =
        values_of(DaylightSampler(object.windows, object.sphere, options).Draw(object.sky));
    sum.resize(values.size());
    squares.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum[i] += values[i];
      squares[i] += values[i] * values[i];
    }
  }
  SeedSpread spread;
  spread.seeds = seeds;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const double mean = sum[i] / seeds;
    spread.mean += mean / static_cast<double>(sum.size());
    if (seeds > 1) spread.variance += (squares[i] - seeds * mean * mean) / (seeds - 1);
  }
  return spread;
}

}  // namespace pleinair

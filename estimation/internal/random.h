// A small seeded random stream that gives the same numbers with every compiler.
#pragma once

#include <cstdint>

#include "scene/low_discrepancy.h"

namespace pleinair::estimation_internal {

// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}

  std::uint64_t Next() {
    const std::uint64_t bits = HashBits(state_);
    state_ += kGoldenGamma;
    return bits;
  }
  // In [0, 1).
  double Uniform() { return UnitFromHash(Next()); }
  // In 0 .. count - 1, count > 0.
  int Below(int count) { return static_cast<int>(Uniform() * count); }

 private:
  std::uint64_t state_;
};

}  // namespace pleinair::estimation_internal

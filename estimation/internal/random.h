// A small seeded random stream that gives the same numbers with every compiler.
#pragma once

#include <cstdint>

namespace pleinair::estimation_internal {

// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}

  std::uint64_t Next() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  // In [0, 1).
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  // In 0 .. count - 1, count > 0.
  int Below(int count) { return static_cast<int>(Uniform() * count); }

 private:
  std::uint64_t state_;
};

}  // namespace pleinair::estimation_internal

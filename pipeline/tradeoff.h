// Error against time: which settings are worth what they cost.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace pleinair {

// Over seeds.
struct Spread {
  double median = 0.0;
  double smallest = 0.0;
  double largest = 0.0;
};

// None of no values.
std::optional<Spread> SpreadOf(std::span<const double> values);

// One setting. Of the same seeds, in the same order, as the others of its sweep.
struct TradeoffPoint {
  std::vector<double> error;
  std::vector<double> time_ms;
};

// Where a point stands among the others, by its medians.
struct FrontPlace {
  // No other point has less error for no more time, or takes less time for no more error.
  bool on_front = true;
  // The point with the least error of those that beat it; none for points on the front.
  std::optional<std::size_t> beaten_by;
  int seeds_beaten = 0;  // Of `seeds`, pair by pair, those with which that one has less error.
  int seeds = 0;
};

// One entry a point. A point without values is not on the front, and beats none.
std::vector<FrontPlace> PlacesOnFront(std::span<const TradeoffPoint> points);

}  // namespace pleinair

// Error against time, for values of settings.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace pleinair {

// Statistics over seeds.
struct Spread {
  double median = 0.0;
  double smallest = 0.0;
  double largest = 0.0;
};

// None without values.
std::optional<Spread> SpreadOf(std::span<const double> values);

// One setting, with the same seeds in the same order as the others of its sweep.
struct TradeoffPoint {
  std::vector<double> error;
  std::vector<double> time_ms;
};

// A point's rank among the others, by its medians.
struct FrontPlace {
  // No other point has less error for no more time, or takes less time for no more error.
  bool on_front = true;
  // Among the points that beat it, the one with the least error; none for points on the front.
  std::optional<std::size_t> beaten_by;
  // How many of `seeds`, compared in pairs, give that point less error.
  int seeds_beaten = 0;
  int seeds = 0;
};

// One entry for each point. A point without values is not on the front, and beats none.
std::vector<FrontPlace> PlacesOnFront(std::span<const TradeoffPoint> points);

}  // namespace pleinair

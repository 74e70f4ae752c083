// Medians and percentiles of a score.
#pragma once

#include <optional>
#include <vector>

namespace pleinair {

// Order statistics of values.
struct Distribution {
  int count = 0;
  double smallest = 0.0;
  double median = 0.0;
  double percentile_95 = 0.0;
  double largest = 0.0;
};

// The value below which `share` (0..1) of the values lie, linearly between the two order statistics
// next to (count - 1) share. Throws std::invalid_argument for no values or a share outside 0..1.
double Percentile(std::vector<double> values, double share);

// None of no values.
std::optional<double> Median(std::vector<double> values);

// None of no values.
std::optional<Distribution> DistributionOf(const std::vector<double>& values);

}  // namespace pleinair

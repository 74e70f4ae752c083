// Making curves rise.
#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/response_fit.h"

namespace pleinair {

std::vector<double> IsotonicRegression(std::span<const double> values,
                                       std::span<const double> weights) {
  struct Pool {
    double mean;
    double weight;
    std::size_t count;
  };
  std::vector<Pool> pools;
  for (std::size_t i = 0; i < values.size(); ++i) {
    pools.push_back({values[i], weights[i], 1});
    while (pools.size() > 1 && pools[pools.size() - 2].mean > pools.back().mean) {
      const Pool upper = pools.back();
      pools.pop_back();
      Pool& lower = pools.back();
      const double weight = lower.weight + upper.weight;
      lower.mean = (lower.mean * lower.weight + upper.mean * upper.weight) / weight;
      lower.weight = weight;
      lower.count += upper.count;
    }
  }
  std::vector<double> result;
  result.reserve(values.size());
  for (const Pool& pool : pools) result.insert(result.end(), pool.count, pool.mean);
  return result;
}

std::array<float, 256> StrictlyRising(const std::array<double, 256>& linear_of_code) {
  // A step of 1e-5 of the value, and 1e-9 of white at the dark end. That is some hundred times the
  // resolution of a float of that size, and at most 0.3 % of white in all.
  constexpr double kRelativeStep = 1e-5;
  constexpr double kSmallestStep = 1e-9;
  double largest = 0.0;
  for (const double value : linear_of_code) {
    if (std::isfinite(value)) largest = std::max(largest, value);
  }
  std::array<double, 256> rising{};
  double previous = 0.0;
  for (std::size_t code = 0; code < 256; ++code) {
    double value = linear_of_code[code] / largest;
    if (!(value >= 0.0) || !std::isfinite(value)) value = 0.0;
    if (code > 0) {
      value = std::max(value, previous * (1.0 + kRelativeStep) + kSmallestStep);
    }
    rising[code] = value;
    previous = value;
  }
  std::array<float, 256> table{};
  for (std::size_t code = 0; code < 256; ++code) {
    table[code] = static_cast<float>(rising[code] / rising[255]);
  }
  table[255] = 1.0f;
  return table;
}

}  // namespace pleinair

#include "datasets/statistics.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace pleinair {

double Percentile(std::vector<double> values, double share) {
  if (values.empty()) throw std::invalid_argument("percentile of no values");
  if (!(share >= 0.0 && share <= 1.0)) {
    throw std::invalid_argument("share " + std::to_string(share) + ": expected 0 to 1");
  }
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(place));
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], place - std::floor(place));
}

std::optional<double> Median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  return Percentile(std::move(values), 0.5);
}

std::optional<Distribution> DistributionOf(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return Distribution{static_cast<int>(values.size()),
                      *std::min_element(values.begin(), values.end()),
                      Percentile(values, 0.5),
                      Percentile(values, 0.95),
                      *std::max_element(values.begin(), values.end())};
}

}  // namespace pleinair

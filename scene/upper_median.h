// The upper median, as robust measures use it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace pleinair {

// 0 of an empty set, and depends on the values alone, whose order it changes.
inline double UpperMedianInPlace(std::span<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The same of a copy.
inline double UpperMedian(std::vector<double> values) { return UpperMedianInPlace(values); }

}  // namespace pleinair

// The upper median, as every robust scale here uses it.
#pragma once

#include <algorithm>
#include <vector>

namespace pleinair::estimation_internal {

// Of a non-empty set, whose order it changes. Depends on the values alone, not on their order.
inline double UpperMedian(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace pleinair::estimation_internal

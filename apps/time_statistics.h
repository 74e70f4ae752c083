// Median, percentiles and largest of any number of times, in bounded memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pleinair {

class TimeStatistics {
 public:
  // Negative times count as 0.
  void Add(double ms);
  std::int64_t Count() const { return count_; }
  double LargestMs() const { return largest_ms_; }
  // To half a per cent, from 1 us to 1 h; 0 without times. `share` in [0, 1]: 0.5 is the median.
  double QuantileMs(double share) const;

 private:
  // Bins whose edges are a factor of 1.01 apart.
  static constexpr std::size_t kBins = 2212;
  std::array<std::int64_t, kBins> bins_{};
  std::int64_t count_ = 0;
  double largest_ms_ = 0.0;
};

}  // namespace pleinair

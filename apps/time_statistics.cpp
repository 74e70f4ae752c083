#include "apps/time_statistics.h"

#include <algorithm>
#include <cmath>

namespace pleinair {
namespace {

constexpr double kSmallestMs = 1e-3;
const double kLogOfBin = std::log(1.01);

}  // namespace

void TimeStatistics::Add(double ms) {
  const double above = std::log(std::max(ms, kSmallestMs) / kSmallestMs) / kLogOfBin;
  ++bins_[std::min(static_cast<std::size_t>(above), kBins - 1)];
  ++count_;
  largest_ms_ = std::max(largest_ms_, ms);
}

double TimeStatistics::QuantileMs(double share) const {
  if (count_ == 0) return 0.0;
  const auto wanted = static_cast<std::int64_t>(std::floor(share * static_cast<double>(count_)));
  std::int64_t below = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    below += bins_[bin];
    if (below <= std::min(wanted, count_ - 1)) continue;
    const double middle = kSmallestMs * std::exp((static_cast<double>(bin) + 0.5) * kLogOfBin);
    return std::min(middle, largest_ms_);
  }
  return largest_ms_;
}

}  // namespace pleinair

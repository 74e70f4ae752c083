// Quantiles of many times against those of the sorted list.
#include "apps/time_statistics.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair::time_statistics_test {
namespace {

constexpr double kAccuracy = 0.005;  // As the header states it.

// The value that `share` of all are below.
double Exact(std::vector<double> times, double share) {
  std::sort(times.begin(), times.end());
  const auto wanted = static_cast<std::size_t>(share * static_cast<double>(times.size()));
  return times[std::min(wanted, times.size() - 1)];
}

TEST(TimeStatistics, QuantilesAreThoseOfTheSortedTimesToHalfAPerCent) {
  std::mt19937 random(4);
  std::lognormal_distribution<double> usual(3.0, 1.5);
  // From a microsecond to an hour, evenly in the logarithm.
  std::uniform_real_distribution<double> decades(-3.0, std::log10(3.6e6));
  for (const bool is_usual : {true, false}) {
    TimeStatistics statistics;
    std::vector<double> times;
    for (int i = 0; i < 20'001; ++i) {
      times.push_back(is_usual ? usual(random) : std::pow(10.0, decades(random)));
      statistics.Add(times.back());
    }
    EXPECT_EQ(statistics.Count(), 20'001);
    EXPECT_EQ(statistics.LargestMs(), *std::max_element(times.begin(), times.end()));
    for (const double share : {0.0, 0.01, 0.25, 0.5, 0.9, 0.99, 0.999, 1.0}) {
      EXPECT_NEAR(statistics.QuantileMs(share) / Exact(times, share), 1.0, kAccuracy) << share;
    }
  }
}

TEST(TimeStatistics, OneTimeIsEachQuantile) {
  for (const double ms : {0.001, 0.5, 33.3, 3.6e6}) {
    TimeStatistics statistics;
    statistics.Add(ms);
    for (const double share : {0.0, 0.5, 1.0}) {
      EXPECT_NEAR(statistics.QuantileMs(share) / ms, 1.0, kAccuracy) << ms;
      EXPECT_LE(statistics.QuantileMs(share), statistics.LargestMs());
    }
  }
}

TEST(TimeStatistics, NoTimesAreZero) {
  const TimeStatistics none;
  EXPECT_EQ(none.Count(), 0);
  EXPECT_EQ(none.QuantileMs(0.5), 0.0);
  EXPECT_EQ(none.LargestMs(), 0.0);
}

// A clock that was stepped gives times below 0 and of days: they are counted, at the ends.
TEST(TimeStatistics, TimesOutsideTheRangeCountAtItsEnds) {
  TimeStatistics statistics;
  statistics.Add(-5.0);
  statistics.Add(0.0);
  statistics.Add(1e9);
  EXPECT_EQ(statistics.Count(), 3);
  EXPECT_LE(statistics.QuantileMs(0.0), 0.0011);
  EXPECT_LE(statistics.QuantileMs(0.5), 0.0011);
  EXPECT_GE(statistics.QuantileMs(1.0), 3.6e6 * (1.0 - kAccuracy));
  EXPECT_EQ(statistics.LargestMs(), 1e9);
}

}  // namespace
}  // namespace pleinair::time_statistics_test

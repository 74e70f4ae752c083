// Searches the front of error against time over combinations of settings, with few trials.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace pleinair {

// One value of each setting, as its index.
using Combination = std::vector<int>;

// Cost of a combination. All above 0; one time for each way of use (still, moving).
struct CombinationCost {
  double error = 0.0;
  std::vector<double> time_ms;
};

// A combination and its measured cost.
struct TriedCombination {
  Combination combination;
  std::optional<CombinationCost> cost;  // None where it could not be measured.
};

// Set-up of the search.
struct FrontSearch {
  std::vector<int> value_counts;   // Number of values, for each setting.
  std::vector<Combination> start;  // Tried first; at least one. Others vary the first one.
  int most_trials = 60;            // The start and its variations by one value included.
  int batch = 6;                   // Measured together.

  // Throws std::invalid_argument naming the field; for more than 4 million combinations.
  void Validate() const;
};

// Returns one entry for each combination.
using MeasureCombinations =
    std::function<std::vector<std::optional<CombinationCost>>(std::span<const Combination>)>;

// Tries combinations and returns all that were tried, in that order.
//
// Method  First the start, then each other value of one setting. The change by a value (error by a
//         difference, times by a factor) is assumed to be the same elsewhere, beginning from the
//         tried combination with the fewest other values. Then those untried combinations are tried
//         that are expected farthest below the front of error against one of the times.
//         Measurements correct later expectations. Ends after most_trials, or where nothing is
//         expected to be better by more than a hundredth.
// Cost    without measuring: combinations x trials, each batch.
//
// The same costs lead to the same trials: there is no randomness.
std::vector<TriedCombination> SearchFront(const FrontSearch& search,
                                          const MeasureCombinations& measure);

}  // namespace pleinair

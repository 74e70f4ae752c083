// Which combinations of settings are worth what they cost: a search that tries few of many.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace pleinair {

// One value of each setting, as its index.
using Combination = std::vector<int>;

// What a combination costs. All above 0; one time for each way of use (still, moving).
struct CombinationCost {
  double error = 0.0;
  std::vector<double> time_ms;
};

struct TriedCombination {
  Combination combination;
  std::optional<CombinationCost> cost;  // None where it could not be measured.
};

struct FrontSearch {
  std::vector<int> value_counts;   // Of each setting.
  std::vector<Combination> start;  // Tried first; at least one, and the first is what others vary.
  int most_trials = 60;            // The start and its variations by one value among them.
  int batch = 6;                   // Measured at once.

  // Throws std::invalid_argument naming the field; for more than 4 million combinations.
  void Validate() const;
};

// One entry a combination.
using MeasureCombinations =
    std::function<std::vector<std::optional<CombinationCost>>(std::span<const Combination>)>;

// Tries combinations and returns all that were tried, in that order.
//
// Method  First the start, then each of its settings' other values by itself. What a value changes
//         there (error by a difference, times by a factor) is taken to hold elsewhere, beginning
//         from the tried combination with the fewest other values; of the untried ones those are
//         tried that should lie farthest below the front of error against one of the times. What
//         is measured corrects what is expected next. Ends after most_trials, or where nothing
//         is expected to be better by more than a hundredth.
// Cost    beside measuring: combinations x trials, each batch.
//
// The same costs lead to the same trials: chance has no part in it.
std::vector<TriedCombination> SearchFront(const FrontSearch& search,
                                          const MeasureCombinations& measure);

}  // namespace pleinair

#include "pipeline/front_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

namespace pleinair {
namespace {

constexpr double kMostCombinations = 4e6;
constexpr double kWorthTrying = 0.01;  // As a logarithm of error or time.
// An expected error is not below this share of the least that was measured: differences add up to
// less than nothing.
constexpr double kLeastExpectedShare = 0.5;

// Steps down: the least error that is had for so much time.
class ErrorOverTime {
 public:
  void Add(double time_ms, double error) { points_.emplace_back(time_ms, error); }

  // Distance, as a logarithm, of a point below the front; negative: above.
  double Below(double time_ms, double error) const {
    double least = std::numeric_limits<double>::infinity();
    double quickest_ms = std::numeric_limits<double>::infinity();
    double largest = 0.0;
    for (const auto& [other_ms, other_error] : points_) {
      if (other_ms <= time_ms) least = std::min(least, other_error);
      quickest_ms = std::min(quickest_ms, other_ms);
      largest = std::max(largest, other_error);
    }
    if (std::isfinite(least)) return std::log(least / error);
    // Quicker than all: the gain of time, as far as the error is not worse than all.
    return std::log(quickest_ms / time_ms) + std::min(0.0, std::log(largest / error));
  }

 private:
  std::vector<std::pair<double, double>> points_;
};

class Search {
 public:
  Search(const FrontSearch& search, const MeasureCombinations& measure)
      : search_(search), measure_(measure) {}

  std::vector<TriedCombination> Run() {
    Try(search_.start);
    Try(Variations());
    LearnEffects();
    while (effects_known_) {
      const std::vector<Combination> next = MostPromising();
      if (next.empty()) break;
      Try(next);
    }
    return std::move(tried_);
  }

 private:
  struct Effect {
    bool is_known = true;
    double error = 0.0;
    std::vector<double> log_time;
  };

  std::size_t Left() const {
    const auto most = static_cast<std::size_t>(search_.most_trials);
    return tried_.size() < most ? most - tried_.size() : 0;
  }

  // Measures in batches; combinations that were tried already are skipped.
  void Try(std::vector<Combination> combinations) {
    std::erase_if(combinations, [&](const Combination& c) { return !known_.insert(c).second; });
    combinations.resize(std::min(combinations.size(), Left()));
    const auto batch = static_cast<std::size_t>(search_.batch);
    for (std::size_t begin = 0; begin < combinations.size(); begin += batch) {
      const std::span<const Combination> part =
          std::span(combinations).subspan(begin, std::min(batch, combinations.size() - begin));
      std::vector<std::optional<CombinationCost>> costs = measure_(part);
      costs.resize(part.size());
      for (std::size_t i = 0; i < part.size(); ++i) {
        tried_.push_back({part[i], std::move(costs[i])});
      }
    }
  }

  std::vector<Combination> Variations() const {
    std::vector<Combination> variations;
    for (std::size_t s = 0; s < search_.value_counts.size(); ++s) {
      for (int value = 0; value < search_.value_counts[s]; ++value) {
        Combination varied = search_.start.front();
        varied[s] = value;
        variations.push_back(std::move(varied));
      }
    }
    return variations;
  }

  const std::optional<CombinationCost>* CostOf(const Combination& combination) const {
    const auto found = std::find_if(tried_.begin(), tried_.end(), [&](const auto& tried) {
      return tried.combination == combination;
    });
    return found == tried_.end() ? nullptr : &found->cost;
  }

  void LearnEffects() {
    const std::optional<CombinationCost>* start = CostOf(search_.start.front());
    effects_known_ = start != nullptr && start->has_value();
    if (!effects_known_) return;
    effects_.resize(search_.value_counts.size());
    for (std::size_t s = 0; s < effects_.size(); ++s) {
      for (int value = 0; value < search_.value_counts[s]; ++value) {
        Combination varied = search_.start.front();
        varied[s] = value;
        Effect& effect = effects_[s].emplace_back();
        const std::optional<CombinationCost>* cost = CostOf(varied);
        effect.is_known = cost != nullptr && cost->has_value();
        if (!effect.is_known) continue;
        effect.error = (*cost)->error - (*start)->error;
        for (std::size_t t = 0; t < (*start)->time_ms.size(); ++t) {
          effect.log_time.push_back(std::log((*cost)->time_ms[t] / (*start)->time_ms[t]));
        }
      }
    }
  }

  // Expected cost, by the nearest measured one. None where a value's effect is not known.
  std::optional<CombinationCost> Expected(const Combination& combination,
                                          double least_error) const {
    const TriedCombination* nearest = nullptr;
    std::size_t nearest_others = std::numeric_limits<std::size_t>::max();
    for (const TriedCombination& tried : tried_) {
      if (!tried.cost) continue;
      std::size_t others = 0;
      for (std::size_t s = 0; s < combination.size(); ++s) {
        others += tried.combination[s] != combination[s] ? 1 : 0;
      }
      if (others < nearest_others) {
        nearest_others = others;
        nearest = &tried;
      }
    }
    CombinationCost expected = *nearest->cost;
    for (std::size_t s = 0; s < combination.size(); ++s) {
      const Effect& is = effects_[s][static_cast<std::size_t>(combination[s])];
      const Effect& was = effects_[s][static_cast<std::size_t>(nearest->combination[s])];
      if (!is.is_known) return std::nullopt;
      if (!was.is_known) continue;
      expected.error += is.error - was.error;
      for (std::size_t t = 0; t < expected.time_ms.size(); ++t) {
        expected.time_ms[t] *= std::exp(is.log_time[t] - was.log_time[t]);
      }
    }
    expected.error = std::max(expected.error, kLeastExpectedShare * least_error);
    return expected;
  }

  bool Next(Combination& combination) const {
    for (std::size_t s = 0; s < combination.size(); ++s) {
      if (++combination[s] < search_.value_counts[s]) return true;
      combination[s] = 0;
    }
    return false;
  }

  // The times in turn; what is chosen counts as measured for those after it.
  std::vector<Combination> MostPromising() const {
    double least_error = std::numeric_limits<double>::infinity();
    std::size_t times = 0;
    for (const TriedCombination& tried : tried_) {
      if (!tried.cost) continue;
      least_error = std::min(least_error, tried.cost->error);
      times = tried.cost->time_ms.size();
    }
    std::vector<ErrorOverTime> fronts(times);
    for (const TriedCombination& tried : tried_) {
      if (!tried.cost) continue;
      for (std::size_t t = 0; t < times; ++t) {
        fronts[t].Add(tried.cost->time_ms[t], tried.cost->error);
      }
    }
    // Combinations that are expected below the present front.
    std::vector<std::pair<Combination, CombinationCost>> candidates;
    Combination combination(search_.value_counts.size(), 0);
    do {
      if (known_.contains(combination)) continue;
      const std::optional<CombinationCost> expected = Expected(combination, least_error);
      if (!expected) continue;
      for (std::size_t t = 0; t < times; ++t) {
        if (fronts[t].Below(expected->time_ms[t], expected->error) <= kWorthTrying) continue;
        candidates.emplace_back(combination, *expected);
        break;
      }
    } while (Next(combination));

    std::vector<Combination> chosen;
    const std::size_t most = std::min(static_cast<std::size_t>(search_.batch), Left());
    std::size_t without = 0;
    for (std::size_t turn = 0; chosen.size() < most && without < times; ++turn) {
      const std::size_t t = turn % times;
      double most_below = kWorthTrying;
      const std::pair<Combination, CombinationCost>* best = nullptr;
      for (const auto& candidate : candidates) {
        const double below = fronts[t].Below(candidate.second.time_ms[t], candidate.second.error);
        if (below <= most_below) continue;
        most_below = below;
        best = &candidate;
      }
      without = best == nullptr ? without + 1 : 0;
      if (best == nullptr) continue;
      chosen.push_back(best->first);
      for (std::size_t k = 0; k < times; ++k) {
        fronts[k].Add(best->second.time_ms[k], best->second.error);
      }
    }
    return chosen;
  }

  const FrontSearch& search_;
  const MeasureCombinations& measure_;
  std::vector<TriedCombination> tried_;
  std::set<Combination> known_;
  bool effects_known_ = false;
  // Effect of each setting's values, relative to the start.
  std::vector<std::vector<Effect>> effects_;
};

}  // namespace

void FrontSearch::Validate() const {
  double combinations = 1.0;
  for (const int count : value_counts) {
    if (count < 1) throw std::invalid_argument("value_counts: expected at least one value each");
    combinations *= count;
  }
  if (!(combinations <= kMostCombinations)) {
    throw std::invalid_argument("value_counts: " + std::to_string(combinations) +
                                " combinations: expected at most " +
                                std::to_string(kMostCombinations));
  }
  if (start.empty()) throw std::invalid_argument("start: expected at least one combination");
  for (const Combination& combination : start) {
    bool fits = combination.size() == value_counts.size();
    for (std::size_t s = 0; fits && s < combination.size(); ++s) {
      fits = combination[s] >= 0 && combination[s] < value_counts[s];
    }
    if (!fits) throw std::invalid_argument("start: expected one of each setting's values");
  }
  if (most_trials < 1) throw std::invalid_argument("most_trials: expected at least 1");
  if (batch < 1) throw std::invalid_argument("batch: expected at least 1");
}

std::vector<TriedCombination> SearchFront(const FrontSearch& search,
                                          const MeasureCombinations& measure) {
  search.Validate();
  return Search(search, measure).Run();
}

}  // namespace pleinair

#include "pipeline/front_search.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pleinair::front_search_test {
namespace {

// Six settings of four values: 4096 combinations. Each setting has its own share of time, its own
// gain of accuracy, and, as in the program, some matter only with others.
const FrontSearch kSearch{{4, 4, 4, 4, 4, 4}, {{2, 2, 2, 2, 2, 2}}, 80, 6};

CombinationCost CostOf(const Combination& c) {
  const auto part = [&](std::size_t s, double weight) { return weight * std::pow(0.4, c[s]); };
  // The second setting is of no use where the first is at its least.
  const double second = c[0] == 0 ? 0.8 : part(1, 0.8);
  const double error = 1.0 + part(0, 2.0) + second + std::hypot(part(2, 1.5), part(3, 1.0)) +
                       part(4, 0.05) + (c[5] == 1 ? 0.3 : 0.0);
  const double still = 1.0 + 0.5 * std::pow(2.0, c[0]) + 0.2 * std::pow(3.0, c[2]) + 0.1 * c[5];
  const double moving = 5.0 + std::pow(3.0, c[1]) + std::pow(2.0, c[3]) + 4.0 * c[4] + c[0];
  return {error, {still, moving}};
}

std::vector<std::optional<CombinationCost>> Measure(std::span<const Combination> combinations) {
  std::vector<std::optional<CombinationCost>> costs;
  for (const Combination& combination : combinations) costs.emplace_back(CostOf(combination));
  return costs;
}

std::vector<Combination> All() {
  std::vector<Combination> all;
  for (int i = 0; i < 4096; ++i) {
    Combination combination;
    for (int s = 0, rest = i; s < 6; ++s, rest /= 4) combination.push_back(rest % 4);
    all.push_back(combination);
  }
  return all;
}

double LeastError(const std::vector<TriedCombination>& tried, std::size_t t, double time_ms) {
  double least = std::numeric_limits<double>::infinity();
  for (const TriedCombination& one : tried) {
    if (one.cost && one.cost->time_ms[t] <= time_ms) least = std::min(least, one.cost->error);
  }
  return least;
}

// How far, as a mean logarithm of errors, the front of `tried` is above that of all; for each of
// the true front's times that buy an error worth having.
double MeanAboveTrueFront(const std::vector<TriedCombination>& tried, std::size_t t) {
  std::vector<TriedCombination> all;
  for (const Combination& combination : All()) all.push_back({combination, CostOf(combination)});
  double sum = 0.0;
  int points = 0;
  for (const TriedCombination& one : all) {
    const double time_ms = one.cost->time_ms[t];
    constexpr double kWorthHaving = 3.5;  // The least is 1.3, the largest 6.
    if (one.cost->error > std::min(kWorthHaving, LeastError(all, t, time_ms))) continue;
    const double found = LeastError(tried, t, time_ms);
    sum += std::isfinite(found) ? std::log(found / one.cost->error) : 1.0;
    ++points;
  }
  return sum / points;
}

TEST(FrontSearch, FindsTheFrontWithFewTrials) {
  const std::vector<TriedCombination> tried = SearchFront(kSearch, Measure);
  EXPECT_LE(tried.size(), 80u);
  std::vector<TriedCombination> by_chance;
  std::mt19937 random(1);
  std::vector<Combination> all = All();
  std::shuffle(all.begin(), all.end(), random);
  for (std::size_t i = 0; i < 80; ++i) by_chance.push_back({all[i], CostOf(all[i])});
  for (const std::size_t t : {0u, 1u}) {
    EXPECT_LT(MeanAboveTrueFront(tried, t), 0.1) << "time " << t;
    EXPECT_LT(MeanAboveTrueFront(tried, t), 0.5 * MeanAboveTrueFront(by_chance, t)) << "time " << t;
  }
}

TEST(FrontSearch, TriesEachCombinationOnceAndTheStartFirst) {
  FrontSearch search = kSearch;
  search.start = {{2, 2, 2, 2, 2, 2}, {0, 0, 0, 0, 0, 0}, {3, 3, 3, 3, 3, 3}};
  std::set<Combination> seen;
  const std::vector<TriedCombination> tried =
      SearchFront(search, [&](std::span<const Combination> combinations) {
        EXPECT_LE(combinations.size(), 6u);
        for (const Combination& c : combinations) EXPECT_TRUE(seen.insert(c).second);
        return Measure(combinations);
      });
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(tried[i].combination, search.start[i]);
  EXPECT_EQ(tried.size(), seen.size());
  const std::vector<TriedCombination> again = SearchFront(search, Measure);
  ASSERT_EQ(again.size(), tried.size());
  for (std::size_t i = 0; i < tried.size(); ++i) {
    EXPECT_EQ(again[i].combination, tried[i].combination);
  }
}

TEST(FrontSearch, EndsWhereNothingIsBetter) {
  const FrontSearch search{{3, 3}, {{0, 0}}, 50, 4};
  const auto tried = SearchFront(search, [](std::span<const Combination> combinations) {
    return std::vector<std::optional<CombinationCost>>(combinations.size(),
                                                       CombinationCost{1.0, {1.0, 1.0}});
  });
  EXPECT_EQ(tried.size(), 5u) << "the start and its variations";
}

TEST(FrontSearch, GoesOnWithoutWhatCannotBeMeasured) {
  const auto tried = SearchFront(kSearch, [](std::span<const Combination> combinations) {
    auto costs = Measure(combinations);
    for (std::size_t i = 0; i < combinations.size(); ++i) {
      if (combinations[i][2] == 3) costs[i].reset();
    }
    return costs;
  });
  EXPECT_GT(tried.size(), 30u);
  int failed = 0;
  for (const TriedCombination& one : tried) failed += one.cost ? 0 : 1;
  EXPECT_EQ(failed, 1) << "a value that fails by itself is not combined";

  const auto none = SearchFront(kSearch, [](std::span<const Combination> combinations) {
    return std::vector<std::optional<CombinationCost>>(combinations.size());
  });
  EXPECT_EQ(none.size(), 19u) << "the start and its variations";
}

TEST(FrontSearch, RefusesWhatItCannotSearch) {
  const auto refuses = [](FrontSearch search) {
    EXPECT_THROW(SearchFront(search, Measure), std::invalid_argument);
  };
  refuses({{2, 0}, {{0, 0}}});
  refuses({{2, 2}, {}});
  refuses({{2, 2}, {{0, 2}}});
  refuses({{2, 2}, {{0}}});
  refuses({std::vector<int>(12, 10), {Combination(12, 0)}});
}

}  // namespace
}  // namespace pleinair::front_search_test

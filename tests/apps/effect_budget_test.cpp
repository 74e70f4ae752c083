// How much time live frames' effects get, frame by frame.
#include "apps/effect_budget.h"

#include <vector>

#include <gtest/gtest.h>

namespace pleinair::effect_budget_test {
namespace {

EffectPlan Plan(EffectFate fate, double bound_code_values) {
  EffectPlan plan;
  plan.effects[1].fate = fate;
  plan.effects[1].bound_code_values = bound_code_values;
  return plan;
}

// Visible, and left out: for the budget alone.
const EffectPlan kShort = Plan(EffectFate::kLeftOut, 100.0);
const EffectPlan kComplete = Plan(EffectFate::kRun, 100.0);
const EffectPlan kInvisible = Plan(EffectFate::kLeftOut, 1e-3);

// The frames without a budget, of so many.
std::vector<int> Unlimited(EffectBudget budget, const EffectPlan& plan, int frames) {
  std::vector<int> unlimited;
  for (int frame = 0; frame < frames; ++frame) {
    if (!budget.Next().budget_ms) unlimited.push_back(frame);
    budget.Look(plan);
  }
  return unlimited;
}

TEST(EffectBudget, IsTheCamerasIntervalAfterTheFirstFrame) {
  EffectBudget budget({}, 25.0);
  EXPECT_FALSE(budget.Next().budget_ms);
  budget.Look(kComplete);
  for (int frame = 0; frame < 100; ++frame) {
    ASSERT_TRUE(budget.Next().budget_ms);
    EXPECT_DOUBLE_EQ(*budget.Next().budget_ms, 40.0);
    budget.Look(kComplete);
  }
}

TEST(EffectBudget, AStatedOneHoldsForEveryFrame) {
  EffectSettings stated;
  stated.budget_ms = 7.0;
  EffectBudget budget(stated, 30.0);
  for (int frame = 0; frame < 100; ++frame) {
    EXPECT_EQ(budget.Next().budget_ms, 7.0);
    budget.Look(kShort);
  }
}

TEST(EffectBudget, ThereIsNoneWhereTheRateIsUnknown) {
  EffectBudget budget({}, 0.0);
  for (int frame = 0; frame < 40; ++frame) {
    EXPECT_FALSE(budget.Next().budget_ms);
    budget.Look(kShort);
  }
}

// Frames 1 to 15 leave something out: 16 has time; then 30 more frames, then 60, and so on.
TEST(EffectBudget, LetsAFrameTakeItsTimeLessAndLessOftenWhereThatDoesNotHelp) {
  EXPECT_EQ(Unlimited(EffectBudget({}, 30.0), kShort, 500),
            (std::vector<int>{0, 16, 47, 108, 229, 470}));
  // No more than 1800 frames apart: a minute at 30 a second.
  const std::vector<int> hour = Unlimited(EffectBudget({}, 30.0), kShort, 108'000);
  EXPECT_EQ(hour.back() - hour[hour.size() - 2], 1801);
}

TEST(EffectBudget, WhatIsInvisibleIsNotMissed) {
  EXPECT_EQ(Unlimited(EffectBudget({}, 30.0), kInvisible, 200), std::vector<int>{0});
  EXPECT_EQ(Unlimited(EffectBudget({}, 30.0), kComplete, 200), std::vector<int>{0});
}

// A complete frame in between, and the wait is the first one again.
TEST(EffectBudget, WaitsAfreshOnceAFrameWasComplete) {
  EffectBudget budget({}, 30.0);
  for (int frame = 0; frame < 30; ++frame) budget.Look(kShort);
  budget.Look(kComplete);
  EXPECT_EQ(Unlimited(budget, kShort, 20), std::vector<int>{15});
}

TEST(EffectBudget, KeepsAllOtherSettings) {
  EffectSettings settings;
  settings.threshold_code_values = 3.5;
  EffectBudget budget(settings, 30.0);
  budget.Look(kComplete);
  EXPECT_EQ(budget.Next().threshold_code_values, 3.5);
}

}  // namespace
}  // namespace pleinair::effect_budget_test

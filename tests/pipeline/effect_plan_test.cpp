#include "pipeline/effect_plan.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair::effect_plan_test {
namespace {

// Each effect with a work of its own.
struct Case {
  std::vector<EffectOffer> offers;
  std::vector<WorkOffer> works;
  EffectSettings settings;

  explicit Case(double bound = 10.0, double ms = 1.0) {
    for (const Effect effect : kAllEffects) {
      offers.push_back({effect, bound, {}, ""});
      works.push_back({NameOf(effect), ms, ms, false, false, {effect}});
    }
  }
  EffectOffer& Offer(Effect effect) { return offers[static_cast<std::size_t>(effect)]; }
  WorkOffer& Work(Effect effect) { return works[static_cast<std::size_t>(effect)]; }
  EffectPlan Plan(std::optional<double> budget_ms = std::nullopt) const {
    return PlanEffects(settings, offers, works, budget_ms);
  }
};

TEST(EffectPlan, LeavesOutWhatCannotBeSeen) {
  Case all;
  all.Offer(Effect::kSunShadow).bound_code_values = 0.0;
  all.Offer(Effect::kColourBleeding).bound_code_values = 0.7;
  const EffectPlan plan = all.Plan();
  EXPECT_EQ(plan.Of(Effect::kSunShadow).fate, EffectFate::kLeftOut);
  EXPECT_EQ(plan.Of(Effect::kColourBleeding).fate, EffectFate::kLeftOut);
  EXPECT_EQ(plan.Of(Effect::kSkyOcclusion).fate, EffectFate::kRun);
  EXPECT_EQ(plan.left_out_code_values, 0.7);
  EXPECT_EQ(plan.SavedMs(), 2.0);
}

// Two of three fit below the threshold, not all; the pair that costs most goes.
TEST(EffectPlan, SumsBoundsAndSavesTheMostTime) {
  Case all;
  for (const auto& [effect, bound, ms] : {std::tuple{Effect::kSunShadow, 0.6, 5.0},
                                          std::tuple{Effect::kSkyOcclusion, 0.4, 1.0},
                                          std::tuple{Effect::kColourBleeding, 0.3, 3.0}}) {
    all.Offer(effect).bound_code_values = bound;
    all.Work(effect).nominal_ms = all.Work(effect).expected_ms = ms;
  }
  const EffectPlan plan = all.Plan();
  EXPECT_FALSE(plan.runs.Has(Effect::kSunShadow));
  EXPECT_TRUE(plan.runs.Has(Effect::kSkyOcclusion));
  EXPECT_FALSE(plan.runs.Has(Effect::kColourBleeding));
  EXPECT_LE(plan.left_out_code_values, all.settings.threshold_code_values);
}

TEST(EffectPlan, AThresholdsChoiceDoesNotDependOnTheClock) {
  Case all;
  all.Offer(Effect::kSunShadow).bound_code_values = 0.6;
  all.Offer(Effect::kSkyOcclusion).bound_code_values = 0.6;
  all.Work(Effect::kSunShadow).nominal_ms = 2.0;
  const EffectSet runs = all.Plan().runs;
  EXPECT_FALSE(runs.Has(Effect::kSunShadow));
  all.Work(Effect::kSkyOcclusion).expected_ms = 100.0;
  EXPECT_EQ(all.Plan().runs, runs);
}

TEST(EffectPlan, WhatIsPartOfALeftOutEffectIsLeftOutWithIt) {
  Case all;
  all.Offer(Effect::kSunShading).bound_code_values = 0.0;
  all.Offer(Effect::kObjectShadow).needs_any = {Effect::kSunShading};
  EffectPlan plan = all.Plan();
  EXPECT_EQ(plan.Of(Effect::kObjectShadow).fate, EffectFate::kLeftOut);
  EXPECT_EQ(plan.left_out_code_values, 0.0);
  // Forced to run, its bound counts again.
  all.settings[Effect::kSunShading] = EffectSwitch::kOn;
  plan = all.Plan();
  EXPECT_EQ(plan.Of(Effect::kObjectShadow).fate, EffectFate::kRun);
}

// Leaving out one of two that share a work saves nothing: both go, or none.
TEST(EffectPlan, SharedWorkIsSavedOnlyWithAllItsEffects) {
  Case all;
  all.Work(Effect::kColourBleeding).for_any = {Effect::kSkyOcclusion, Effect::kColourBleeding};
  all.Work(Effect::kSkyOcclusion).nominal_ms = all.Work(Effect::kSkyOcclusion).expected_ms = 0.0;
  all.Offer(Effect::kColourBleeding).bound_code_values = 0.9;
  EXPECT_TRUE(all.Plan().runs.Has(Effect::kColourBleeding));
  all.Offer(Effect::kSkyOcclusion).bound_code_values = 0.1;
  EXPECT_FALSE(all.Plan().runs.HasAny({Effect::kSkyOcclusion, Effect::kColourBleeding}));
}

TEST(EffectPlan, KeptWorkCostsNothingAndIsReported) {
  Case all;
  all.Offer(Effect::kSkyOcclusion).bound_code_values = 0.5;
  all.Work(Effect::kSkyOcclusion) = {"kept", 0.0, 0.0, true, false, {Effect::kSkyOcclusion}};
  EXPECT_EQ(all.Plan().Of(Effect::kSkyOcclusion).fate, EffectFate::kKept);
  EXPECT_EQ(all.Plan().Of(Effect::kSkyOcclusion).expected_ms, 0.0);
}

TEST(EffectPlan, OffAndOnAreObeyed) {
  Case all(0.0);
  all.settings[Effect::kPenumbra] = EffectSwitch::kOn;
  all.settings[Effect::kSunShadow] = EffectSwitch::kOff;
  all.Offer(Effect::kSunShadow).bound_code_values = 200.0;
  const EffectPlan plan = all.Plan();
  EXPECT_EQ(plan.runs, EffectSet{Effect::kPenumbra});
  EXPECT_EQ(plan.Of(Effect::kSunShadow).fate, EffectFate::kOff);
  EXPECT_EQ(plan.left_out_code_values, 0.0);
  all.settings = EffectSettings::Everything();
  EXPECT_EQ(all.Plan().runs, EffectSet::All());
}

TEST(EffectPlan, ABudgetBuysTheLargestBounds) {
  Case all(1.0, 2.0);
  all.Offer(Effect::kSunShading).bound_code_values = 100.0;
  all.Offer(Effect::kProbeShading).bound_code_values = 50.0;
  const EffectPlan plan = all.Plan(4.5);
  EXPECT_EQ(plan.runs, (EffectSet{Effect::kSunShading, Effect::kProbeShading}));
  EXPECT_EQ(plan.left_out_code_values, static_cast<double>(kEffectCount - 2));
  EXPECT_TRUE(plan.fits_budget);
  EXPECT_EQ(all.Plan(1000.0).runs, EffectSet::All());
  all.settings[Effect::kColourBleeding] = EffectSwitch::kOn;
  const EffectPlan none = all.Plan(0.5);
  EXPECT_EQ(none.runs,
            (EffectSet{Effect::kSunShading, Effect::kProbeShading, Effect::kColourBleeding}))
      << "an object is never black";
  EXPECT_FALSE(none.fits_budget);
}

TEST(EffectPlan, ABudgetMissesAnEdgeLessThanABlackObject) {
  Case all(200.0, 2.0);
  for (EffectOffer& offer : all.offers) offer.rms_share = 0.01;
  all.Offer(Effect::kProbeShading).rms_share = 0.3;
  all.Work(Effect::kProbeShading).expected_ms = 5.0;
  all.Offer(Effect::kSunShading).bound_code_values = 0.5;  // Too dark to be seen.
  const EffectPlan plan = all.Plan(5.5);
  EXPECT_EQ(plan.runs, EffectSet{Effect::kProbeShading});
  EXPECT_NEAR(plan.left_out_rms_code_values, 2.0 * std::sqrt(kEffectCount - 2.0), 1e-4);
  all.Offer(Effect::kProbeShading).rms_share = -0.1;
  EXPECT_THROW(all.Plan(), std::invalid_argument);
}

// Laws over many random cases: the threshold is kept, no cheaper choice is passed over that leaves
// out one effect less or more, and a higher threshold or budget is never worse.
TEST(EffectPlan, HoldsItsBoundsInAnyCase) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> bound(0.0, 0.6);
  std::uniform_real_distribution<double> ms(0.0, 5.0);
  std::uniform_int_distribution<std::uint32_t> set(0, EffectSet::All().Bits());
  int partly = 0;
  for (int i = 0; i < 200; ++i) {
    Case all;
    for (const Effect effect : kAllEffects) {
      all.Offer(effect).bound_code_values = bound(random);
      all.Offer(effect).rms_share = bound(random);
      WorkOffer& work = all.Work(effect);
      work.nominal_ms = work.expected_ms = ms(random);
      work.for_any = EffectSet::FromBits(set(random) & set(random)).With(effect);
    }
    const EffectPlan plan = all.Plan();
    EXPECT_LE(plan.left_out_code_values, 1.0);
    partly += plan.runs.Empty() || plan.runs == EffectSet::All() ? 0 : 1;
    all.settings.threshold_code_values = 2.0;
    EXPECT_LE(all.Plan().expected_ms, plan.expected_ms);
    const EffectPlan bought = all.Plan(plan.expected_ms);
    EXPECT_LE(bought.expected_ms, plan.expected_ms);
    EXPECT_LE(bought.left_out_rms_code_values, plan.left_out_rms_code_values + 1e-12);
    EXPECT_LE(all.Plan(plan.expected_ms + 3.0).left_out_rms_code_values,
              bought.left_out_rms_code_values + 1e-12);
  }
  EXPECT_GT(partly, 100);
}

TEST(EffectPlan, RefusesNumbersThatMakeNoSense) {
  Case all;
  all.Offer(Effect::kPenumbra).bound_code_values = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(all.Plan(), std::invalid_argument);
  Case late;
  late.Work(Effect::kPenumbra).expected_ms = -1.0;
  EXPECT_THROW(late.Plan(), std::invalid_argument);
  EffectSettings settings;
  settings.threshold_code_values = -1.0;
  EXPECT_THROW(settings.Validate(), std::invalid_argument);
  settings = {};
  settings.budget_ms = 0.0;
  EXPECT_THROW(settings.Validate(), std::invalid_argument);
}

}  // namespace
}  // namespace pleinair::effect_plan_test

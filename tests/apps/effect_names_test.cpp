// What --effects makes of names.
#include "apps/effect_names.h"

#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace pleinair::effect_names_test {
namespace {

using Names = std::vector<std::string>;

EffectSettings Chosen(const Names& names) {
  EffectSettings settings;
  settings.switches = SwitchesOf(names);
  return settings;
}

TEST(EffectNames, AllAndPlanAreOfAll) {
  EXPECT_EQ(SwitchesOf(Names{"all"}), EffectSettings::Filled(EffectSwitch::kOn));
  EXPECT_EQ(SwitchesOf(Names{"plan"}), EffectSettings::Filled(EffectSwitch::kPlan));
}

TEST(EffectNames, ThoseThatAreNamedAreOnAndTheOthersOff) {
  const EffectSettings chosen = Chosen({"probe-shading"});
  for (const Effect effect : kAllEffects) {
    const bool is_on = effect == Effect::kProbeShading || effect == Effect::kDaylight ||
                       effect == Effect::kLocalLight || effect == Effect::kAmbientOcclusion ||
                       effect == Effect::kLightUpdate;
    EXPECT_EQ(chosen[effect], is_on ? EffectSwitch::kOn : EffectSwitch::kOff) << NameOf(effect);
  }
  EXPECT_EQ(Chosen({"sun-shadow"})[Effect::kObjectShadow], EffectSwitch::kOn);
  const EffectSettings planned = Chosen({"plan", "penumbra"});
  EXPECT_EQ(planned[Effect::kPenumbra], EffectSwitch::kOn);
  EXPECT_EQ(planned[Effect::kSunShadow], EffectSwitch::kPlan);
}

TEST(EffectNames, OneIsLeftOutOfAllOfThePlanAndOfThoseNamed) {
  for (const auto& [names, others] : {std::pair{Names{"all", "no-penumbra"}, EffectSwitch::kOn},
                                      std::pair{Names{"plan", "no-penumbra"}, EffectSwitch::kPlan},
                                      std::pair{Names{"no-penumbra"}, EffectSwitch::kPlan}}) {
    const EffectSettings chosen = Chosen(names);
    for (const Effect effect : kAllEffects) {
      EXPECT_EQ(chosen[effect], effect == Effect::kPenumbra ? EffectSwitch::kOff : others)
          << names[0] << ": " << NameOf(effect);
    }
  }
  EXPECT_EQ(Chosen({"sun-shadow", "no-object-shadow"})[Effect::kObjectShadow], EffectSwitch::kOff);
}

TEST(EffectNames, AllOfThemAreKnown) {
  std::set<std::string> expected{"plan", "all"};
  for (const Effect effect : kAllEffects) {
    expected.insert(std::string(NameOf(effect)));
    expected.insert("no-" + std::string(NameOf(effect)));
  }
  const Names names = NamesOfSwitches();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()), expected);
  EXPECT_EQ(names.size(), expected.size());
}

}  // namespace
}  // namespace pleinair::effect_names_test

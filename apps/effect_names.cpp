#include "apps/effect_names.h"

#include <algorithm>
#include <string_view>

#include "pipeline/effect.h"

namespace pleinair {
namespace {

std::string Without(Effect effect) { return "no-" + std::string(NameOf(effect)); }

}  // namespace

std::vector<std::string> NamesOfSwitches() {
  std::vector<std::string> names{"plan", "all"};
  for (const Effect effect : kAllEffects) {
    names.emplace_back(NameOf(effect));
    names.push_back(Without(effect));
  }
  return names;
}

decltype(EffectSettings::switches) SwitchesOf(std::span<const std::string> names) {
  const auto is_named = [names](std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  const bool names_some = std::any_of(kAllEffects.begin(), kAllEffects.end(), [&](Effect effect) {
    return is_named(NameOf(effect));
  });
  const EffectSwitch others = is_named("all")                   ? EffectSwitch::kOn
                              : is_named("plan") || !names_some ? EffectSwitch::kPlan
                                                                : EffectSwitch::kOff;
  EffectSettings effects;
  effects.switches = EffectSettings::Filled(others);
  for (const Effect effect : kAllEffects) {
    if (IsWayOfOthers(effect) && others == EffectSwitch::kOff) {
      effects[effect] = EffectSwitch::kOn;
    }
    if (!is_named(NameOf(effect))) continue;
    effects[effect] = EffectSwitch::kOn;
    for (const Effect other : kAllEffects) {
      if (BroughtBy(effect).Has(other)) effects[other] = EffectSwitch::kOn;
    }
  }
  for (const Effect effect : kAllEffects) {
    if (is_named(Without(effect))) effects[effect] = EffectSwitch::kOff;
  }
  return effects.switches;
}

}  // namespace pleinair

// Effects as a user names them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/effect_plan.h"

namespace pleinair {

// All words that SwitchesOf accepts: plan, all, an effect's name, and no-NAME.
std::vector<std::string> NamesOfSwitches();

// Named effects are on. The others are on where `all` is named. They are left to the plan where
// `plan` is named, or no effect is named except to be left out; else they are off. An effect brings
// those that it is incomplete without: the shadow on objects comes with that of objects, sampled
// daylight with what it is part of. no-NAME is off whatever else is named.
decltype(EffectSettings::switches) SwitchesOf(std::span<const std::string> names);

}  // namespace pleinair

// Effects as a user names them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/effect_plan.h"

namespace pleinair {

// All that SwitchesOf knows: plan, all, an effect's name, and no-NAME.
std::vector<std::string> NamesOfSwitches();

// Effects by name are on. The others are on where `all` is named, left to the plan where `plan` is
// or no effect is but to be left out, and else off. What an effect would be half of itself without
// comes with it: the shadow on objects with that of objects, sampled daylight with what it is part
// of. no-NAME is off whatever else is named.
decltype(EffectSettings::switches) SwitchesOf(std::span<const std::string> names);

}  // namespace pleinair

#include "pipeline/effect.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "pipeline/internal/effects/frame_effect.h"

namespace pleinair {

std::string_view NameOf(Effect effect) { return DefinitionOf(effect).name; }

std::string_view HelpOf(Effect effect) { return DefinitionOf(effect).help; }

EffectSet BroughtBy(Effect effect) { return DefinitionOf(effect).brings; }

bool IsWayOfOthers(Effect effect) { return DefinitionOf(effect).is_way_of_others; }

void EffectSettings::Validate() const {
  if (!(threshold_code_values >= 0.0) || !std::isfinite(threshold_code_values)) {
    throw std::invalid_argument("threshold_code_values is " +
                                std::to_string(threshold_code_values) +
                                ": expected 0 or more code values");
  }
  if (budget_ms && (!(*budget_ms > 0.0) || !std::isfinite(*budget_ms))) {
    throw std::invalid_argument("budget_ms is " + std::to_string(*budget_ms) +
                                ": expected more than 0 milliseconds");
  }
}

}  // namespace pleinair

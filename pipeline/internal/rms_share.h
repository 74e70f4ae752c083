// What a picture usually loses by leaving an effect out: what a budget goes by.
#pragma once

#include "pipeline/effect_plan.h"

namespace pleinair {

// For EffectOffer::rms_share: what recordings change by without the effect, over a bound of 255
// (docs/accuracy.md, "A budget"). Of kCurrentLight the least: see RmsShareOfOlderLight.
double RmsShareOf(Effect effect);

// Of light that the sun has left so far behind.
double RmsShareOfOlderLight(double sun_gone_on_rad);

}  // namespace pleinair

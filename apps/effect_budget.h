// How much time a live frame's effects get.
#pragma once

#include <cstdint>
#include <optional>

#include "pipeline/effect_plan.h"

namespace pleinair {

// A budget that is stated holds for every frame. Else it is the camera's interval; but work whose
// result stays (light on an object that stands still) may take many intervals once, and would never
// fit: the first frame has no budget, and a frame now and then, where effects are left out for the
// budget alone.
class EffectBudget {
 public:
  // `frames_per_second`: 0 where it is not known: then there is no budget.
  EffectBudget(const EffectSettings& settings, double frames_per_second);

  // Of the next frame.
  EffectSettings Next() const;
  // What the last Next made of it.
  void Look(const EffectPlan& plan);

 private:
  EffectSettings settings_;
  std::optional<double> interval_ms_;
  bool is_unlimited_ = true;       // The next frame.
  std::int64_t short_frames_ = 0;  // In a row, that left something out for the budget.
  std::int64_t wait_frames_ = 0;   // Of those, before one is without budget.
};

}  // namespace pleinair

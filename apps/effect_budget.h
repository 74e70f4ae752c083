// How much time a live frame's effects get.
#pragma once

#include <cstdint>
#include <optional>

#include "pipeline/effect_plan.h"

namespace pleinair {

// A stated budget holds for every frame. Without one, the budget is the camera's interval. Work
// whose result stays (light on an object that stands still) may take many intervals once, and would
// never fit. So the first frame has no budget, nor has an occasional later one, where effects are
// left out for the budget alone.
class EffectBudget {
 public:
  // `frames_per_second`: 0 where it is not known: then there is no budget.
  EffectBudget(const EffectSettings& settings, double frames_per_second);

  // Settings for the next frame.
  EffectSettings Next() const;
  // Takes the plan that was made with the last Next.
  void Look(const EffectPlan& plan);

 private:
  EffectSettings settings_;
  std::optional<double> interval_ms_;
  bool is_unlimited_ = true;       // The next frame has no budget.
  std::int64_t short_frames_ = 0;  // Successive frames that left something out for the budget.
  std::int64_t wait_frames_ = 0;   // Number of those before one is without budget.
};

}  // namespace pleinair

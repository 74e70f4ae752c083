#include "apps/effect_budget.h"

#include <algorithm>

namespace pleinair {
namespace {

// Half a second at 30 frames a second; then twice as long each time, as it did not help.
constexpr std::int64_t kFirstWaitFrames = 15;
constexpr std::int64_t kLongestWaitFrames = 1800;

// Effects that are too dark to be seen are left out with any budget.
bool IsShort(const EffectPlan& plan, double threshold_code_values) {
  return std::any_of(plan.effects.begin(), plan.effects.end(), [&](const PlannedEffect& effect) {
    return effect.fate == EffectFate::kLeftOut && effect.bound_code_values > threshold_code_values;
  });
}

}  // namespace

EffectBudget::EffectBudget(const EffectSettings& settings, double frames_per_second)
    : settings_(settings), wait_frames_(kFirstWaitFrames) {
  if (!settings.budget_ms && frames_per_second > 0.0) interval_ms_ = 1000.0 / frames_per_second;
}

EffectSettings EffectBudget::Next() const {
  EffectSettings next = settings_;
  if (interval_ms_ && !is_unlimited_) next.budget_ms = interval_ms_;
  return next;
}

void EffectBudget::Look(const EffectPlan& plan) {
  if (!interval_ms_) return;
  if (is_unlimited_) {
    is_unlimited_ = false;
    return;
  }
  if (!IsShort(plan, settings_.threshold_code_values)) {
    short_frames_ = 0;
    wait_frames_ = kFirstWaitFrames;
    return;
  }
  if (++short_frames_ < wait_frames_) return;
  is_unlimited_ = true;
  short_frames_ = 0;
  wait_frames_ = std::min(2 * wait_frames_, kLongestWaitFrames);
}

}  // namespace pleinair

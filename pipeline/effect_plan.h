// Which effects a frame needs: enough that the others are not visible, or as many as a time allows.
// A function from numbers to a choice; each effect computes its numbers for a scene (effects/).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "pipeline/effect.h"

namespace pleinair {

// An effect's statement before it is run.
struct EffectOffer {
  Effect effect = Effect::kSunShading;
  // What leaving it out changes in any pixel, at most, where the effects of `needs_any` are run.
  // The plan treats it as an upper bound; local-light's is an estimate with a margin.
  double bound_code_values = 0.0;
  // It is part of these effects: where none of them is run it is not run either, and their bounds
  // include it.
  EffectSet needs_any = {};
  std::string_view why = {};  // The reason for the bound, in few words.
  // Estimate of what leaving it out changes, as a root mean square over the objects' pixels, over
  // its bound. A budget uses it: a missing edge changes a picture less than an object that stays
  // black, though both may change some pixel from black to white.
  double rms_share = 1.0;
};

// A piece of work that effects share. It is done where one of `for_any`, all of `with_all` and none
// of `without` are run.
struct WorkOffer {
  std::string_view name;
  // The same on every machine and in every run, so that what a threshold leaves out does not depend
  // on measured times.
  double nominal_ms = 0.0;
  double expected_ms = 0.0;  // Here and now.
  bool is_kept = false;      // The last frame's result stands.
  bool is_drawing = false;   // Done in every frame; cannot be kept.
  EffectSet for_any;
  EffectSet with_all = {};
  EffectSet without = {};

  bool IsNeededFor(EffectSet effects) const {
    return effects.HasAny(for_any) && effects.HasAll(with_all) && !effects.HasAny(without);
  }
};

// What the plan did with an effect.
enum class EffectFate : std::uint8_t {
  kOff,      // Switched off.
  kLeftOut,  // By the plan.
  kKept,     // Run, and everything slow is kept from the last frame.
  kRun,
};

// One effect in the plan.
struct PlannedEffect {
  Effect effect = Effect::kSunShading;
  EffectFate fate = EffectFate::kOff;
  // In code values; 0 where it is part of another effect that is left out.
  double bound_code_values = 0.0;
  // The time that it adds, or would add, to that of the other effects that are run.
  double expected_ms = 0.0;
  std::string_view why;
};

// The choice for one frame. Times in milliseconds.
struct EffectPlan {
  std::array<PlannedEffect, kEffectCount> effects{};  // By Effect.
  EffectSet runs;
  double left_out_code_values = 0.0;  // Sum of the bounds.
  // Estimate of that change: a root mean square over as many pixels as the objects have.
  double left_out_rms_code_values = 0.0;
  double expected_ms = 0.0;      // For the effects' works, without drawing of the objects.
  double all_expected_ms = 0.0;  // With all effects that are not off.
  bool fits_budget = true;       // True without one.

  double SavedMs() const { return all_expected_ms - expected_ms; }
  const PlannedEffect& Of(Effect effect) const { return effects[static_cast<std::size_t>(effect)]; }
};

// Returns a choice of effects.
// - Without a budget: among the choices whose left-out bounds add up to at most the threshold, the
//   one with the least nominal time.
// - With `budget_ms` for the works: among the choices expected to fit into it, the one with the
//   least left_out_rms_code_values; the cheapest where none fits. All of them have sun-shading and
//   probe-shading where these are not off and exceed the threshold: objects are not black.
// An effect that is on is run where the effects that it is part of are. Among equal choices the one
// that leaves out more is taken.
//
// `offers` has one entry for each effect, in the order of kAllEffects. All choices are tried:
// exact, and up to a millisecond where nothing is decided.
// Throws std::invalid_argument for offers in another order, or a bound, share or time that is below
// 0 or not finite.
EffectPlan PlanEffects(const EffectSettings& settings,
                       std::span<const EffectOffer> offers,
                       std::span<const WorkOffer> works,
                       std::optional<double> budget_ms);

}  // namespace pleinair

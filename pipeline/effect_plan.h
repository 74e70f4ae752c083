// Which effects a frame calls for: as many as needed so that what is left out cannot be seen, or as
// many as a time allows. Plain numbers in, a choice out; what they say of a scene is each effect's
// (effects/).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "pipeline/effect.h"

namespace pleinair {

// What an effect says before it is run.
struct EffectOffer {
  Effect effect = Effect::kSunShading;
  // Upper bound of what leaving it out changes in any pixel, the effects of `needs_any` being run.
  double bound_code_values = 0.0;
  // It is part of these: where none of them is run it is not run either, and their bounds include
  // it.
  EffectSet needs_any = {};
  std::string_view why = {};  // The bound is what it is; in few words.
  // What leaving it out changes, as a root mean square over the objects' pixels, over its bound:
  // about, as it usually is. A budget goes by it: an edge is missed less than an object that stays
  // black, though both may change some pixel from black to white.
  double rms_share = 1.0;
};

// A piece of work that effects share: it is done where one of `for_any`, all of `with_all` and none
// of `without` are run.
struct WorkOffer {
  std::string_view name;
  // The same on every machine and in every run, so that what a threshold leaves out does not depend
  // on measured times.
  double nominal_ms = 0.0;
  double expected_ms = 0.0;  // Here and now.
  bool is_kept = false;      // The last frame's result stands.
  bool is_drawing = false;   // In every frame, and not to be kept.
  EffectSet for_any;
  EffectSet with_all = {};
  EffectSet without = {};

  bool IsNeededFor(EffectSet effects) const {
    return effects.HasAny(for_any) && effects.HasAll(with_all) && !effects.HasAny(without);
  }
};

enum class EffectFate : std::uint8_t {
  kOff,      // Not asked for.
  kLeftOut,  // By the plan.
  kKept,     // Run, and all that is slow about it is the last frame's.
  kRun,
};

struct PlannedEffect {
  Effect effect = Effect::kSunShading;
  EffectFate fate = EffectFate::kOff;
  // 0 where it is part of another effect that is left out.
  double bound_code_values = 0.0;
  // What it adds, or would add, to the time of the others that are run.
  double expected_ms = 0.0;
  std::string_view why;
};

struct EffectPlan {
  std::array<PlannedEffect, kEffectCount> effects{};  // By Effect.
  EffectSet runs;
  double left_out_code_values = 0.0;  // Sum of the bounds.
  // About what that changes: a root mean square over as many pixels as the objects have.
  double left_out_rms_code_values = 0.0;
  double expected_ms = 0.0;      // Of the effects' works, drawing of the objects left out.
  double all_expected_ms = 0.0;  // With everything that is not off.
  bool fits_budget = true;       // True without one.

  double SavedMs() const { return all_expected_ms - expected_ms; }
  const PlannedEffect& Of(Effect effect) const { return effects[static_cast<std::size_t>(effect)]; }
};

// Without a budget: of the choices whose left-out bounds add up to at most the threshold, the one
// that takes the least nominal time. With `budget_ms` for the works: of the choices expected to fit
// into it, the one with the least left_out_rms_code_values; the cheapest where none fits. An
// effect that is on is run where what it needs is. Of equals the one that leaves out more.
//
// `offers` has one entry an effect, in the order of kAllEffects. All choices are tried: exact, and
// up to a millisecond where nothing is decided.
// Throws std::invalid_argument for offers in another order, or a bound, share or time that is below
// 0 or not finite.
EffectPlan PlanEffects(const EffectSettings& settings,
                       std::span<const EffectOffer> offers,
                       std::span<const WorkOffer> works,
                       std::optional<double> budget_ms);

}  // namespace pleinair

#include "pipeline/effect_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <tuple>

namespace pleinair {
namespace {

void RequireNotNegative(double value, std::string_view name, const char* what) {
  if (value >= 0.0 && std::isfinite(value)) return;
  throw std::invalid_argument(std::string("effect plan: ") + what + " of " + std::string(name) +
                              " is " + std::to_string(value) + ": expected 0 or more");
}

double SumOf(double WorkOffer::*time, std::span<const WorkOffer> works, EffectSet runs) {
  double ms = 0.0;
  for (const WorkOffer& work : works) {
    if (work.IsNeededFor(runs)) ms += work.*time;
  }
  return ms;
}

double ExpectedMs(std::span<const WorkOffer> works, EffectSet runs) {
  return SumOf(&WorkOffer::expected_ms, works, runs);
}

// Whether what the effect is part of is run.
bool HasItsNeeds(const EffectOffer& offer, EffectSet runs) {
  return offer.needs_any.Empty() || runs.HasAny(offer.needs_any);
}

// Effects that are not off and have their needs, but are not run.
template <class Visit>
void ForLeftOut(const EffectSettings& settings,
                std::span<const EffectOffer> offers,
                EffectSet runs,
                const Visit& visit) {
  for (const EffectOffer& offer : offers) {
    if (settings[offer.effect] == EffectSwitch::kOff || runs.Has(offer.effect)) continue;
    if (HasItsNeeds(offer, runs)) visit(offer);
  }
}

// An effect that is off, or lacks the effects that it needs, does not run; one that is on runs
// where it has them.
bool IsAllowed(const EffectSettings& settings,
               std::span<const EffectOffer> offers,
               EffectSet runs) {
  return std::all_of(offers.begin(), offers.end(), [&](const EffectOffer& offer) {
    const EffectSwitch wanted = settings[offer.effect];
    if (runs.Has(offer.effect)) {
      return wanted != EffectSwitch::kOff && HasItsNeeds(offer, runs);
    }
    return wanted != EffectSwitch::kOn || !HasItsNeeds(offer, runs);
  });
}

// Without these objects are black: no budget is so small.
constexpr EffectSet kLightOnObjects{Effect::kSunShading, Effect::kProbeShading};

// Effects that no choice has, and those that all have. An effect cannot be left out where its own
// bound is above the threshold and it is part of no other; with a budget, only light on objects
// cannot.
struct DecidedEffects {
  EffectSet never;
  EffectSet always;
};

DecidedEffects Decided(const EffectSettings& settings,
                       std::span<const EffectOffer> offers,
                       bool has_budget) {
  DecidedEffects decided;
  for (const EffectOffer& offer : offers) {
    const EffectSwitch wanted = settings[offer.effect];
    const bool is_independent = offer.needs_any.Empty();
    const bool is_seen = (!has_budget || kLightOnObjects.Has(offer.effect)) &&
                         offer.bound_code_values > settings.threshold_code_values;
    // An effect that changes nothing only takes time.
    const bool is_idle = wanted == EffectSwitch::kPlan && offer.bound_code_values == 0.0;
    if (wanted == EffectSwitch::kOff || is_idle) decided.never = decided.never.With(offer.effect);
    if (is_independent &&
        (wanted == EffectSwitch::kOn || (wanted == EffectSwitch::kPlan && is_seen))) {
      decided.always = decided.always.With(offer.effect);
    }
  }
  return decided;
}

EffectSet Everything(const EffectSettings& settings, std::span<const EffectOffer> offers) {
  EffectSet all;
  for (const EffectOffer& offer : offers) {
    if (settings[offer.effect] != EffectSwitch::kOff) all = all.With(offer.effect);
  }
  EffectSet runs = all;
  for (const EffectOffer& offer : offers) {
    if (!HasItsNeeds(offer, all)) runs = runs.Without(offer.effect);
  }
  return runs;
}

bool IsKept(std::span<const WorkOffer> works, EffectSet runs, Effect effect) {
  bool any_kept = false;
  for (const WorkOffer& work : works) {
    const bool is_its = work.for_any.Has(effect) || work.with_all.Has(effect);
    if (work.is_drawing || !is_its || !work.IsNeededFor(runs)) continue;
    if (!work.is_kept) return false;
    any_kept = true;
  }
  return any_kept;
}

}  // namespace

EffectPlan PlanEffects(const EffectSettings& settings,
                       std::span<const EffectOffer> offers,
                       std::span<const WorkOffer> works,
                       std::optional<double> budget_ms) {
  if (offers.size() != kEffectCount) {
    throw std::invalid_argument("effect plan: " + std::to_string(offers.size()) +
                                " offers, expected " + std::to_string(kEffectCount));
  }
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    if (offers[i].effect != kAllEffects[i]) {
      throw std::invalid_argument("effect plan: offer " + std::to_string(i) + " is " +
                                  std::string(NameOf(offers[i].effect)) + ", expected " +
                                  std::string(NameOf(kAllEffects[i])));
    }
    RequireNotNegative(offers[i].bound_code_values, NameOf(kAllEffects[i]), "the bound");
    RequireNotNegative(offers[i].rms_share, NameOf(kAllEffects[i]), "the rms share");
  }
  for (const WorkOffer& work : works) {
    RequireNotNegative(work.expected_ms, work.name, "the expected time");
    RequireNotNegative(work.nominal_ms, work.name, "the nominal time");
  }

  // Least of: over the limit, what the limit is not about, that it is about, effects run.
  using Rank = std::tuple<bool, double, double, int>;
  std::optional<Rank> best_rank;
  EffectPlan plan;
  plan.all_expected_ms = ExpectedMs(works, Everything(settings, offers));
  const auto [never, always] = Decided(settings, offers, budget_ms.has_value());
  for (std::uint32_t bits = 0; bits <= EffectSet::All().Bits(); ++bits) {
    const EffectSet runs = EffectSet::FromBits(bits);
    if (runs.HasAny(never) || !runs.HasAll(always)) continue;
    if (!IsAllowed(settings, offers, runs)) continue;
    double left_out = 0.0;
    double squares = 0.0;  // Changes of several effects are treated as independent.
    ForLeftOut(settings, offers, runs, [&](const EffectOffer& offer) {
      left_out += offer.bound_code_values;
      const double rms = offer.rms_share * offer.bound_code_values;
      squares += rms * rms;
    });
    // No better than what keeps to the limit already, whatever time it takes.
    const bool has_kept_to_it = best_rank && !std::get<0>(*best_rank);
    if (has_kept_to_it && (budget_ms ? squares > std::get<1>(*best_rank)
                                     : left_out > settings.threshold_code_values)) {
      continue;
    }
    const double ms = ExpectedMs(works, runs);
    const int count = std::popcount(bits);
    Rank rank;
    if (budget_ms) {
      rank = ms <= *budget_ms ? Rank{false, squares, ms, count} : Rank{true, ms, squares, count};
    } else {
      const double nominal_ms = SumOf(&WorkOffer::nominal_ms, works, runs);
      rank = left_out <= settings.threshold_code_values ? Rank{false, nominal_ms, left_out, count}
                                                        : Rank{true, left_out, nominal_ms, count};
    }
    if (best_rank && !(rank < *best_rank)) continue;
    best_rank = rank;
    plan.runs = runs;
    plan.left_out_code_values = left_out;
    plan.left_out_rms_code_values = std::sqrt(squares);
    plan.expected_ms = ms;
    plan.fits_budget = !budget_ms || ms <= *budget_ms;
  }

  for (std::size_t i = 0; i < kEffectCount; ++i) {
    const Effect effect = kAllEffects[i];
    PlannedEffect& planned = plan.effects[i];
    planned.effect = effect;
    planned.why = offers[i].why;
    planned.bound_code_values = offers[i].bound_code_values;
    planned.expected_ms =
        ExpectedMs(works, plan.runs.With(effect)) - ExpectedMs(works, plan.runs.Without(effect));
    if (plan.runs.Has(effect)) {
      planned.fate = IsKept(works, plan.runs, effect) ? EffectFate::kKept : EffectFate::kRun;
    } else if (settings[effect] != EffectSwitch::kOff) {
      planned.fate = EffectFate::kLeftOut;
      if (!HasItsNeeds(offers[i], plan.runs)) {
        planned.bound_code_values = 0.0;
        planned.why = "part of what is left out";
      }
    }
  }
  return plan;
}

}  // namespace pleinair

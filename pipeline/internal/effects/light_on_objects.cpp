#include "pipeline/internal/effects/light_on_objects.h"

namespace pleinair {
namespace {

LightCost CostOfLight(const VertexLight& light,
                      const VertexLight::Mode& mode,
                      const FrameBasis& basis,
                      const Lighting& lighting) {
  const VertexLight::Costs expected = light.Expected(mode, basis, lighting);
  const VertexLight::Costs nominal = light.Nominal(mode, basis, lighting);
  const bool is_kept = light.IsCurrent(mode, basis, lighting);
  return {{expected.once_ms + expected.sum_ms,
           nominal.once_ms + nominal.sum_ms,
           is_kept,
           expected.once_ms},
          {expected.now_ms, nominal.now_ms, is_kept, 0.0, expected.now_ms}};
}

}  // namespace

VertexLight::Mode ModeOfLight(const VertexLight& light, EffectSet runs) {
  VertexLight::Mode mode;
  if (!runs.Has(Effect::kLocalLight)) mode.at = VertexLight::At::kSingleProbe;
  mode.with_daylight = runs.Has(Effect::kDaylight);
  mode.with_objects = runs.Has(Effect::kAmbientOcclusion) ||
                      (mode.at == VertexLight::At::kVertices && light.VerticesSeeObjects());
  return mode;
}

LightCosts CostsOfLight(const VertexLight& light,
                        const FrameBasis& basis,
                        const Lighting& lighting) {
  using Mode = VertexLight::Mode;
  using At = VertexLight::At;
  const auto cost_of = [&](const Mode& mode) { return CostOfLight(light, mode, basis, lighting); };
  LightCosts costs;
  costs.at_vertices = cost_of(Mode{.at = At::kVertices, .with_objects = false});
  costs.at_single_probe = cost_of(Mode{.at = At::kSingleProbe, .with_objects = true});
  costs.without_objects = cost_of(Mode{.at = At::kSingleProbe, .with_objects = false});
  const LightCost with_objects = cost_of(Mode{.at = At::kVertices, .with_objects = true});
  costs.between.once_ms = with_objects.lacking.once_ms - costs.at_vertices.lacking.once_ms;
  costs.between.expected_ms = costs.between.once_ms;
  costs.between.is_kept = costs.between.once_ms == 0.0;
  costs.between_is_apart = !light.VerticesSeeObjects();
  return costs;
}

WorkCost CostOfDaylight(const VertexLight& light, const FrameBasis& basis) {
  if (light.IsDaylightCurrent(basis)) return {.is_kept = true};
  return {light.DaylightMs().Ms(), light.DaylightMs().NominalMs()};
}

LikelyLight LikelyLightOf(const EffectSettings& settings,
                          std::span<const EffectOffer> offers,
                          const LightCosts& costs) {
  const auto is_seen = [&](Effect effect) {
    return offers[static_cast<std::size_t>(effect)].bound_code_values >
           settings.threshold_code_values;
  };
  const auto is_likely = [&](Effect effect) {
    return settings[effect] == EffectSwitch::kOn ||
           (settings[effect] == EffectSwitch::kPlan && is_seen(effect));
  };
  LikelyLight likely;
  // Where the plan has yet to decide between two lights that look the same, take the cheaper one.
  const EffectSwitch varies = settings[Effect::kLocalLight];
  const bool at_single_probe = varies == EffectSwitch::kOff ||
                               (varies == EffectSwitch::kPlan && !is_seen(Effect::kLocalLight) &&
                                costs.at_single_probe.NominalMs() <= costs.at_vertices.NominalMs());
  if (!at_single_probe) likely.effects = likely.effects.With(Effect::kLocalLight);
  for (const Effect effect : {Effect::kDaylight, Effect::kAmbientOcclusion}) {
    if (is_likely(effect)) likely.effects = likely.effects.With(effect);
  }
  likely.is_sure = settings[Effect::kProbeShading] == EffectSwitch::kOn ||
                   (!settings.budget_ms && is_likely(Effect::kProbeShading));
  return likely;
}

}  // namespace pleinair

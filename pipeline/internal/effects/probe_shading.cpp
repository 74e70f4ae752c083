// All light on virtual objects but the sun's: sky, and what surfaces reflect.
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/light_on_objects.h"

namespace pleinair {
namespace {

class ProbeShading : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    return LightOnObjects(stage_, frame);
  }

  // The works of all ways of finding light on the objects, for the other effects that need it too.
  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    const WorkCost& between = frame.light.costs.between;
    AddWay(kAtVertices, frame, works);
    works.push_back(WorkOf("light between objects", between, frame, kBetween));
    works.back().offer.with_all = kAtVertices.with_all;
    if (!frame.light.costs.between_is_apart) works.back().offer.for_any = {};
    AddWay(kAtSingleProbe, frame, works);
    AddWay(kWithoutObjects, frame, works);
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.effects.probe_shading = true;
  }

 private:
  struct Way {
    std::string_view name;
    std::string_view name_of_update;
    LightCost LightCosts::*cost;
    EffectSet with_all;
    EffectSet without;
  };
  static constexpr Way kAtVertices{"light at vertices",
                                   "light at vertices, of this sun",
                                   &LightCosts::at_vertices,
                                   {Effect::kLocalLight},
                                   {}};
  static constexpr Way kAtSingleProbe{"light at a single probe",
                                      "light at a single probe, of this sun",
                                      &LightCosts::at_single_probe,
                                      {Effect::kAmbientOcclusion},
                                      {Effect::kLocalLight}};
  static constexpr Way kWithoutObjects{"light at a single probe, without objects",
                                       "light at a single probe, without objects, of this sun",
                                       &LightCosts::without_objects,
                                       {},
                                       {Effect::kLocalLight, Effect::kAmbientOcclusion}};
  static constexpr EffectSet kBetween{Effect::kAmbientOcclusion};

  // Light in that way, then its update for this sun.
  void AddWay(const Way& way, const EffectFrame& frame, std::vector<FrameWork>& works) const {
    const LightBeforePlan& before = frame.light;
    const LightCost& cost = before.costs.*way.cost;
    const auto add = [&](FrameWork work, Refresh refresh) {
      work.offer.with_all = way.with_all;
      work.offer.without = way.without;
      work.make = [this, &frame, refresh](EffectSet runs) {
        VertexLight& light = stage_.Light();
        light.Update(ModeOfLight(light, runs), refresh, frame.basis, frame.lighting);
      };
      works.push_back(std::move(work));
    };
    FrameWork light =
        WorkOf(way.name, cost.lacking, frame, kOnLightAtVertices.With(Effect::kAmbientOcclusion));
    light.sum = [this, &frame](EffectSet runs) { Evaluate(frame, runs); };
    FrameWork update = WorkOf(way.name_of_update, cost.now, frame, {Effect::kLightUpdate});
    if (before.made && &before.costs.Of(*before.made) == &cost) {
      (cost.HasOlder() && before.was_updated ? update : light).ms =
          before.made_ms + before.evaluated_ms;
    }
    add(std::move(light), Refresh::kMissing);
    add(std::move(update), Refresh::kStale);
  }

  void Evaluate(const EffectFrame& frame, EffectSet runs) const {
    if (!runs.Has(Effect::kProbeShading)) return;
    // The light computed before the plan is used where the plan has chosen the same way.
    if (frame.light.made == ModeOfLight(stage_.Light(), runs)) return;
    stage_.Light().Evaluate(frame.basis, frame.lighting);
  }
};

}  // namespace

const EffectDefinition kProbeShadingEffect{
    .name = "probe-shading",
    .help = "sky and reflected light on virtual objects; brings daylight",
    .rms_share = 0.3,
    .make = MakeEffect<ProbeShading>,
    .brings = {Effect::kDaylight}};

}  // namespace pleinair

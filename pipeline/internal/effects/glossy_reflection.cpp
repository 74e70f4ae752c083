// Mirror images in glossy virtual objects.
#include <vector>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"
#include "pipeline/internal/effects/light_on_objects.h"

namespace pleinair {
namespace {

class GlossyReflection : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  EffectSwitch SwitchFor(EffectSwitch asked) const override {
    return asked == EffectSwitch::kOn && !stage_.AnyGlossy() ? EffectSwitch::kPlan : asked;
  }
  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    if (!stage_.AnyGlossy()) return {0.0, "no glossy object"};
    if (!stage_.InView(frame)) return {0.0, "no object in view"};
    // At grazing angles all is reflected.
    const glm::vec3 radiance = kInvPi * stage_.LargestIrradianceOnObjects(frame);
    if (IsDark(radiance)) return {0.0, "no light"};
    return {frame.codes.LargestRise(glm::vec3(0.0f), radiance), "all light in the scene, mirrored"};
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    const LightCost cost =
        stage_.AnyGlossy() ? stage_.Mirror().Cost(frame) : LightCost{{.is_kept = true}, {}};
    works.push_back(WorkOf("mirror image", cost.lacking, frame, {Effect::kGlossyReflection}));
    works.back().make = [this, &frame](EffectSet) {
      stage_.Mirror().Update(stage_, frame, Refresh::kMissing);
    };
    works.back().sum = [this, &frame](EffectSet) { stage_.Mirror().Evaluate(frame); };
    works.push_back(WorkOf("mirror image, of this sun", cost.now, frame, {Effect::kLightUpdate}));
    works.back().offer.with_all = {Effect::kGlossyReflection};
    works.back().make = [this, &frame](EffectSet) {
      stage_.Mirror().Update(stage_, frame, Refresh::kStale);
    };
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.mirrored = &stage_.Mirror().Image();
  }
};

}  // namespace

const EffectDefinition kGlossyReflectionEffect{.name = "glossy-reflection",
                                               .help = "what glossy virtual objects mirror",
                                               .rms_share = 0.13,
                                               .make = MakeEffect<GlossyReflection>};

}  // namespace pleinair

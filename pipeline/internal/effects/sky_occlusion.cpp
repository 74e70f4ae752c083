// Light on real surfaces that virtual objects hide: contact shadows.
#include <vector>

#include "pipeline/internal/effects/bound_terms.h"
#include "pipeline/internal/effects/effect_stage.h"

namespace pleinair {
namespace {

class SkyOcclusion : public FrameEffect {
 public:
  using FrameEffect::FrameEffect;

  Bound BoundOf(const EffectFrame& frame, std::span<const EffectOffer> /*before*/) override {
    const glm::vec3 largest = stage_.LargestIrradiance(frame);
    if (IsDark(largest)) return {0.0, "no light"};
    const InfluenceReach& reach = stage_.Reach(frame);
    if (reach.largest_share == 0.0f) return {0.0, "no surface near an object in view"};
    if (reach.largest_share >= InfluenceReach::kDecisive) {
      return {kWhiteCode, "an object close to a surface"};
    }
    return {ChangeOfReached(frame, reach, reach.largest_share * largest, glm::vec3(0.0f)),
            "objects fill a small share of a surface's view"};
  }

  void AddWorks(const EffectFrame& frame, std::vector<FrameWork>& works) override {
    works.push_back(WorkOf("influence on surfaces",
                           stage_.Influence().Cost(stage_, frame),
                           frame,
                           {Effect::kSkyOcclusion, Effect::kColourBleeding}));
    works.back().make = [this, &frame](EffectSet) { stage_.Influence().Update(stage_, frame); };
    works.back().sum = [this, &frame](EffectSet runs) {
      stage_.Influence().Evaluate(frame.lighting,
                                  {.hidden_light = runs.Has(Effect::kSkyOcclusion),
                                   .object_light = runs.Has(Effect::kColourBleeding)});
    };
    works.push_back(DrawingOf("draw relit surfaces", kDrawMs, frame, kOnSurfaces));
  }

  void Draw(const EffectFrame& /*frame*/, CompositeInput& input) const override {
    input.irradiance_change = &stage_.Influence().Change();
  }

 private:
  static constexpr double kDrawMs = 1.5;  // Nominal, of relit surfaces: see kDrawObjectsMs.
};

}  // namespace

const EffectDefinition kSkyOcclusionEffect{
    .name = "sky-occlusion",
    .help = "what virtual objects hide of sky and reflected light from surfaces; brings daylight",
    .rms_share = 0.025,
    .make = MakeEffect<SkyOcclusion>,
    .brings = {Effect::kDaylight}};

}  // namespace pleinair
